// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/view/offscreen.hpp"

#include <array>
#include <cmath>

#include "host/base/error.hpp"

namespace haptable {

namespace {

/// A frame buffer with colour and depth; OpenGL counts 0 samples where there is no multisampling.
GLuint make_frame_buffer(int width, int height, GLsizei samples) {
    GLuint frame = 0;
    std::array<GLuint, 2> store{};
    glGenFramebuffers(1, &frame);
    glBindFramebuffer(GL_FRAMEBUFFER, frame);
    glGenRenderbuffers(2, store.data());
    glBindRenderbuffer(GL_RENDERBUFFER, store[0]);
    glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, GL_RGBA8, width, height);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, store[0]);
    glBindRenderbuffer(GL_RENDERBUFFER, store[1]);
    glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, GL_DEPTH_COMPONENT24, width, height);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, store[1]);
    if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
        throw Error("OSMesa gives no frame buffer of " + std::to_string(width) + "x" + std::to_string(height) +
                    ": choose a smaller --size");
    return frame;
}

GLuint compile(GLenum kind, const std::string& source) {
    const GLuint shader = glCreateShader(kind);
    const char* text = source.c_str();
    glShaderSource(shader, 1, &text, nullptr);
    glCompileShader(shader);
    GLint good = 0;
    glGetShaderiv(shader, GL_COMPILE_STATUS, &good);
    if (good != GL_TRUE) {
        std::array<char, 1000> log{};
        glGetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), nullptr, log.data());
        throw Error(std::string("OSMesa does not take a shader: ") + log.data() + ": is Mesa 20 or newer installed?");
    }
    return shader;
}

/// A colour multiplied by its opacity, 0xAARRGGBB, over an opaque one, 0x00RRGGBB.
std::uint32_t over(std::uint32_t front, std::uint32_t back) {
    const std::uint32_t through = 255U - (front >> 24U);
    if (through == 0) return front & 0x00FFFFFFU;
    std::uint32_t out = 0;
    for (unsigned shift = 0; shift < 24; shift += 8) {
        const std::uint32_t shines = ((back >> shift & 0xFFU) * through + 127U) / 255U;
        out |= std::min((front >> shift & 0xFFU) + shines, 255U) << shift;
    }
    return out;
}

}  // namespace

Offscreen::Offscreen(int width, int height, int samples) : width_(width), height_(height) {
    const int attributes[] = {OSMESA_FORMAT,
                              OSMESA_BGRA,
                              OSMESA_DEPTH_BITS,
                              24,
                              OSMESA_PROFILE,
                              OSMESA_CORE_PROFILE,
                              OSMESA_CONTEXT_MAJOR_VERSION,
                              3,
                              OSMESA_CONTEXT_MINOR_VERSION,
                              3,
                              0};
    context_.reset(OSMesaCreateContextAttribs(attributes, nullptr));
    if (!context_) throw Error("OSMesa gives no OpenGL 3.3 context: install Debian's libosmesa6");
    window_.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    make_current();
    resolved_ = make_frame_buffer(width, height, 0);
    drawing_ = samples > 1 ? make_frame_buffer(width, height, samples) : resolved_;
}

Offscreen::~Offscreen() = default;

void Offscreen::make_current() {
    if (OSMesaMakeCurrent(context_.get(), window_.data(), GL_UNSIGNED_BYTE, width_, height_) != GL_TRUE)
        throw Error("OSMesa cannot draw " + std::to_string(width_) + "x" + std::to_string(height_) +
                    ": choose a smaller --size");
    glBindFramebuffer(GL_FRAMEBUFFER, drawing_);
    glViewport(0, 0, width_, height_);
}

void Offscreen::begin(const PixelBox& box) {
    make_current();
    const auto pixel = [](float at, int most) {
        return static_cast<GLint>(std::clamp(at, 0.0F, static_cast<float>(most)));
    };
    left_ = pixel(std::floor(box.left), width_);
    top_ = pixel(std::floor(box.top), height_);
    right_ = std::max(left_, pixel(std::ceil(box.right), width_));
    bottom_ = std::max(top_, pixel(std::ceil(box.bottom), height_));
    glEnable(GL_SCISSOR_TEST);
    glScissor(left_, top_, right_ - left_, bottom_ - top_);
    glClearColor(0.0F, 0.0F, 0.0F, 0.0F);
    glDepthMask(GL_TRUE);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
}

void Offscreen::read_over(Image& image) {
    const GLint columns = right_ - left_;
    const GLint rows = bottom_ - top_;
    if (columns == 0 || rows == 0) return;
    glBindFramebuffer(GL_READ_FRAMEBUFFER, drawing_);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, resolved_);
    if (drawing_ != resolved_)
        glBlitFramebuffer(left_, top_, right_, bottom_, left_, top_, right_, bottom_, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, resolved_);
    drawn_.resize(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
    glReadPixels(left_, top_, columns, rows, GL_BGRA, GL_UNSIGNED_INT_8_8_8_8_REV, drawn_.data());
    glBindFramebuffer(GL_FRAMEBUFFER, drawing_);
    const std::uint32_t* from = drawn_.data();
    for (GLint y = top_; y < bottom_; ++y) {
        std::uint32_t* to = image.pixel.data() + static_cast<std::ptrdiff_t>(y) * width_ + left_;
        for (GLint x = 0; x < columns; ++x, ++from, ++to)
            if (*from != 0) *to = over(*from, *to);
    }
}

GLuint make_program(const std::string& vertex, const std::string& fragment) {
    const GLuint program = glCreateProgram();
    for (const GLuint shader : {compile(GL_VERTEX_SHADER, vertex), compile(GL_FRAGMENT_SHADER, fragment)}) {
        glAttachShader(program, shader);
        glDeleteShader(shader);
    }
    glLinkProgram(program);
    GLint good = 0;
    glGetProgramiv(program, GL_LINK_STATUS, &good);
    if (good != GL_TRUE) {
        std::array<char, 1000> log{};
        glGetProgramInfoLog(program, static_cast<GLsizei>(log.size()), nullptr, log.data());
        throw Error(std::string("OSMesa does not link a shader: ") + log.data());
    }
    return program;
}

void set_uniform(GLuint program, const char* name, float value) {
    glUniform1f(glGetUniformLocation(program, name), value);
}

void set_uniform(GLuint program, const char* name, const Eigen::Vector3f& value) {
    glUniform3fv(glGetUniformLocation(program, name), 1, value.data());
}

void set_uniform(GLuint program, const char* name, const Eigen::Vector4f& value) {
    glUniform4fv(glGetUniformLocation(program, name), 1, value.data());
}

void set_uniform(GLuint program, const char* name, const Eigen::Matrix4f& value) {
    glUniformMatrix4fv(glGetUniformLocation(program, name), 1, GL_FALSE, value.data());
}

Triangles::Triangles(const std::vector<int>& sizes) {
    for (const int size : sizes) floats_ += size;
    glGenVertexArrays(1, &array);
    glBindVertexArray(array);
    glGenBuffers(1, &buffer);
    glBindBuffer(GL_ARRAY_BUFFER, buffer);
    std::size_t offset = 0;
    for (std::size_t a = 0; a < sizes.size(); ++a) {
        glEnableVertexAttribArray(static_cast<GLuint>(a));
        // NOLINTNEXTLINE(performance-no-int-to-ptr): OpenGL takes the offset as a pointer
        const auto* begin = reinterpret_cast<const void*>(offset);
        glVertexAttribPointer(static_cast<GLuint>(a), sizes[a], GL_FLOAT, GL_FALSE,
                              floats_ * static_cast<GLsizei>(sizeof(float)), begin);
        offset += static_cast<std::size_t>(sizes[a]) * sizeof(float);
    }
}

void Triangles::upload(const std::vector<float>& values, GLenum usage) {
    vertices = static_cast<GLsizei>(values.size()) / floats_;
    glBindBuffer(GL_ARRAY_BUFFER, buffer);
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(values.size() * sizeof(float)), values.data(), usage);
}

void Triangles::draw() const {
    glBindVertexArray(array);
    glDrawArrays(GL_TRIANGLES, 0, vertices);
}

}  // namespace haptable
