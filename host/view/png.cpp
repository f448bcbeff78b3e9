// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/view/png.hpp"

#include <png.h>

#include "host/base/error.hpp"
#include "host/base/file.hpp"

namespace haptable {

namespace {

// Rendered pictures are smooth: differences along a row and the fastest compression take a fifth of the time of
// libpng's default and give a file that is half as large again.
constexpr int kCompression = 1;

void append(png_structp png, png_bytep bytes, std::size_t count) {
    static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<const char*>(bytes), count);
}

[[noreturn]] void fail(png_structp, png_const_charp what) { throw Error(std::string("libpng: ") + what); }

void write_rows(png_structp png, png_infop info, const Image& image) {
    png_set_IHDR(png, info, static_cast<png_uint_32>(image.width), static_cast<png_uint_32>(image.height), 8,
                 PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
    png_set_compression_level(png, kCompression);
    png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB);
    png_write_info(png, info);
    png_set_filler(png, 0, PNG_FILLER_AFTER);  // our pixels are blue, green, red, nothing
    png_set_bgr(png);
    const auto width = static_cast<std::size_t>(image.width);
    for (std::size_t y = 0; y < static_cast<std::size_t>(image.height); ++y)
        png_write_row(png, reinterpret_cast<png_const_bytep>(image.pixel.data() + y * width));
    png_write_end(png, info);
}

}  // namespace

std::string encode_png(const Image& image) {
    std::string bytes;
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, fail, nullptr);
    png_infop info = png == nullptr ? nullptr : png_create_info_struct(png);
    if (info == nullptr) throw Error("libpng gives no writer: is there memory left?");
    png_set_write_fn(png, &bytes, append, nullptr);
    try {
        write_rows(png, info, image);
    } catch (...) {
        png_destroy_write_struct(&png, &info);
        throw;
    }
    png_destroy_write_struct(&png, &info);
    return bytes;
}

void write_png(const std::filesystem::path& path, const Image& image) { write_file(path, encode_png(image)); }

}  // namespace haptable
