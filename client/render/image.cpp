#include "client/render/image.h"

#include <png.h>

#include "common/file_system/write_file.h"

namespace pointreel {

Result<void> write_png(const std::string& path, const Image& image) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = static_cast<png_uint_32>(image.width);
  png.height = static_cast<png_uint_32>(image.height);
  png.format = PNG_FORMAT_RGB;
  // Recording many pictures should not wait for the best compression.
  png.flags = PNG_IMAGE_FLAG_FAST;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
  Bytes bytes(size);
  if (!png_image_write_to_memory(&png, bytes.data(), &size, 0, image.pixels.data(), 0, nullptr))
    return fail(ErrorCode::io, path + ": cannot be written: " + png.message);
  return write_file(path, ByteView(bytes).first(size));
}

}  // namespace pointreel
