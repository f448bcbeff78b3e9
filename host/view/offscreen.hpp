// SPDX-License-Identifier: GPL-2.0-or-later
// OpenGL without a display: OSMesa, a multisampled frame buffer, shader programs and vertex buffers.
#pragma once

#define GL_GLEXT_PROTOTYPES
#include <GL/gl.h>
#include <GL/glext.h>
#include <GL/osmesa.h>

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "host/view/image.hpp"

namespace haptable {

/// An OpenGL 3.3 core context and a frame buffer of one or four samples a pixel. All GL calls go to the context that
/// was made or began a picture last. Objects made in it die with it.
class Offscreen {
public:
    /// `samples` a pixel: 1 or 4, the most that Mesa's software rasterizer offers.
    Offscreen(int width, int height, int samples);
    ~Offscreen();
    Offscreen(const Offscreen&) = delete;
    Offscreen& operator=(const Offscreen&) = delete;

    /// Begins a picture in which only the pixels of `box` will be drawn: clearing and averaging four samples a pixel
    /// costs more than drawing, so it is not done for the empty part. What is drawn must leave its opacity as alpha.
    void begin(const PixelBox& box);
    /// Averages the samples and lays what was drawn over the pixels of `image`, which must be as large.
    void read_over(Image& image);

private:
    void make_current();

    struct Destroy {
        void operator()(osmesa_context* context) const { OSMesaDestroyContext(context); }
    };
    int width_;
    int height_;
    std::vector<std::uint32_t> window_;  ///< OSMesa wants a buffer; we draw into frame buffers of our own
    std::unique_ptr<osmesa_context, Destroy> context_;
    std::vector<std::uint32_t> drawn_;                   ///< pixels of the box
    GLint left_ = 0, top_ = 0, right_ = 0, bottom_ = 0;  ///< of what is drawn; the rows count from the top
    GLuint drawing_ = 0;                                 ///< frame buffer with all samples
    GLuint resolved_ = 0;                                ///< with one a pixel; the same one where that is all
};

/// Compiles and links. Throws Error with the compiler's words when it does not.
GLuint make_program(const std::string& vertex, const std::string& fragment);

void set_uniform(GLuint program, const char* name, float value);
void set_uniform(GLuint program, const char* name, const Eigen::Vector3f& value);
void set_uniform(GLuint program, const char* name, const Eigen::Vector4f& value);
void set_uniform(GLuint program, const char* name, const Eigen::Matrix4f& value);

/// Triangles on the graphics side: a vertex array with `floats` floats a vertex.
struct Triangles {
    GLuint array = 0;
    GLuint buffer = 0;
    GLsizei vertices = 0;

    /// `sizes`: floats of each attribute, in order of their locations.
    Triangles(const std::vector<int>& sizes);
    void upload(const std::vector<float>& values, GLenum usage);
    void draw() const;

private:
    GLsizei floats_ = 0;
};

}  // namespace haptable
