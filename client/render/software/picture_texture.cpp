#include "client/render/software/picture_texture.h"

#include <utility>

namespace pointreel {

void PictureTexture::upload(const Picture& picture, const PixelRect& part) {
  const glm::ivec2 size = picture.grid.size;
  if (size != size_) {
    texture_ = gl::make_texture(GL_RGBA8, size.x, size.y);
    for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
      glTextureParameteri(texture_.name(), filter, GL_LINEAR);
    glTextureParameteri(texture_.name(), GL_TEXTURE_SWIZZLE_A, GL_ONE);
    auto framebuffer = gl::make_framebuffer(texture_);
    if (framebuffer) framebuffer_ = *std::move(framebuffer);
    size_ = size;
  }
  if (part.empty()) return;
  const glm::ivec2 extent = part.max - part.min;
  glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  glPixelStorei(GL_UNPACK_ROW_LENGTH, size.x);
  glTextureSubImage2D(texture_.name(), 0, part.min.x, part.min.y, extent.x, extent.y, GL_RGBA,
                      GL_UNSIGNED_BYTE, &picture.colors[picture.index(part.min.x, part.min.y)]);
  glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
}

}  // namespace pointreel
