#include "codec/files/png_picture.h"

#include <csetjmp>
#include <cstddef>
#include <cstring>
#include <string>
#include <vector>

#include <png.h>

#include "codec/files/ply_header.h"
#include "common/base/concat.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

/// libpng leaves by longjmp after an error. So the functions that call it make no objects, and
/// what they need stands in members.
class PngReader {
 public:
  explicit PngReader(ByteView bytes) : rest_(bytes) {
    png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, this, on_error, on_warning);
    if (png_ != nullptr) info_ = png_create_info_struct(png_);
  }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;
  ~PngReader() { png_destroy_read_struct(&png_, &info_, nullptr); }

  /// Reads up to the pixels.
  Result<void> begin(std::uint64_t max_pixels) {
    if (info_ == nullptr) return fail(ErrorCode::limit, "out of memory");
    if (!read_head()) return failed();
    if (std::uint64_t{width()} * height() > max_pixels) {
      return fail(ErrorCode::limit, concat("has ", width(), " x ", height(), " pixels; at most ",
                                           max_pixels, " are accepted"));
    }
    return {};
  }

  std::uint32_t width() const { return png_get_image_width(png_, info_); }
  std::uint32_t height() const { return png_get_image_height(png_, info_); }
  bool is_grey_16() const {
    return png_get_color_type(png_, info_) == PNG_COLOR_TYPE_GRAY &&
           png_get_bit_depth(png_, info_) == 16;
  }
  std::string kind() const {
    const int type = png_get_color_type(png_, info_);
    const char* const what = type == PNG_COLOR_TYPE_GRAY            ? "grey"
                             : (type & PNG_COLOR_MASK_PALETTE) != 0 ? "coloured by a palette"
                             : (type & PNG_COLOR_MASK_COLOR) != 0   ? "coloured"
                                                                    : "grey with transparency";
    return concat(what, ", of ", static_cast<int>(png_get_bit_depth(png_, info_)), " bits");
  }

  /// Reads the pixels, as numbers of 16 bits of this machine, or as red, green and blue of 8 bits.
  Result<void> read(std::uint8_t* to, std::size_t row_bytes, bool as_depth) {
    rows_.resize(height());
    for (std::size_t y = 0; y < rows_.size(); ++y) rows_[y] = to + y * row_bytes;
    if (!read_rows(row_bytes, as_depth)) return failed();
    return {};
  }

 private:
  bool read_head() {
    if (setjmp(png_jmpbuf(png_))) return false;
    png_set_read_fn(png_, this, on_read);
    // Only the pixels count: not what gamma they have, nor texts, which may be compressed.
    png_set_keep_unknown_chunks(png_, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);
    png_read_info(png_, info_);
    return true;
  }

  bool read_rows(std::size_t row_bytes, bool as_depth) {
    if (setjmp(png_jmpbuf(png_))) return false;
    if (as_depth) {
      png_set_swap(png_);
    } else {
      png_set_expand(png_);
      png_set_scale_16(png_);
      png_set_strip_alpha(png_);
      png_set_gray_to_rgb(png_);
    }
    png_set_interlace_handling(png_);
    png_read_update_info(png_, info_);
    if (png_get_rowbytes(png_, info_) != row_bytes) png_error(png_, "its rows have another size");
    png_read_image(png_, rows_.data());
    return true;
  }

  tl::unexpected<Error> failed() const {
    return fail(concat("is not a readable PNG file: ", printable(fault_)));
  }

  static void on_read(png_structp png, png_bytep to, std::size_t size) {
    auto& self = *static_cast<PngReader*>(png_get_io_ptr(png));
    if (size > self.rest_.size()) png_error(png, "it ends too early");
    std::memcpy(to, self.rest_.data(), size);
    self.rest_ = self.rest_.subspan(size);
  }
  [[noreturn]] static void on_error(png_structp png, png_const_charp what) {
    auto& self = *static_cast<PngReader*>(png_get_error_ptr(png));
    std::strncpy(self.fault_, what, sizeof(self.fault_) - 1);
    png_longjmp(png, 1);
  }
  static void on_warning(png_structp, png_const_charp) {}

  ByteView rest_;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
  char fault_[128] = {};
  std::vector<png_bytep> rows_;
};

}  // namespace

bool is_png(ByteView bytes) {
  constexpr std::size_t kSignature = 8;
  return bytes.size() >= kSignature && png_sig_cmp(bytes.data(), 0, kSignature) == 0;
}

Result<DepthPicture> read_depth_png(ByteView bytes, std::uint64_t max_pixels) {
  PngReader png(bytes);
  TRY(png.begin(max_pixels));
  if (!png.is_grey_16()) {
    return fail(ErrorCode::unsupported, concat("is ", png.kind(), "; depth is grey, of 16 bits"));
  }
  DepthPicture picture{png.width(), png.height(), {}};
  picture.values.resize(std::size_t{picture.width} * picture.height);
  TRY(png.read(reinterpret_cast<std::uint8_t*>(picture.values.data()),
               std::size_t{picture.width} * sizeof(std::uint16_t), true));
  return picture;
}

Result<ColorPicture> read_color_png(ByteView bytes, std::uint64_t max_pixels) {
  PngReader png(bytes);
  TRY(png.begin(max_pixels));
  ColorPicture picture{png.width(), png.height(), {}};
  const std::size_t row_bytes = 3 * std::size_t{picture.width};
  picture.rgb.resize(row_bytes * picture.height);
  TRY(png.read(picture.rgb.data(), row_bytes, false));
  return picture;
}

}  // namespace pointreel
