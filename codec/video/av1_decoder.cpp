#include "codec/video/av1_decoder.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include <dav1d/dav1d.h>

#include "common/base/concat.h"
#include "common/base/try.h"

namespace pointreel {

class Av1Decoder::Impl {
 public:
  explicit Impl(const Av1Format& format) : format_(format) {}
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  ~Impl() {
    if (context_ != nullptr) dav1d_close(&context_);
  }

  bool open(int threads) {
    Dav1dSettings settings;
    dav1d_default_settings(&settings);
    settings.n_threads = std::clamp(threads, 1, DAV1D_MAX_THREADS);
    settings.max_frame_delay = 1;
    settings.apply_grain = 0;
    settings.frame_size_limit =
        static_cast<unsigned>(format_.width) * static_cast<unsigned>(format_.height);
    settings.logger = {nullptr, nullptr};
    return dav1d_open(&context_, &settings) == 0;
  }

  Result<Av1Picture> decode(ByteView bytes) {
    Dav1dData data{};
    std::uint8_t* const copy = bytes.empty() ? nullptr : dav1d_data_create(&data, bytes.size());
    if (copy == nullptr) return fail("a picture of the video is missing");
    std::memcpy(copy, bytes.data(), bytes.size());
    Dav1dPicture shown{};
    // The unit may hold more pictures than it should: the last one counts.
    while (true) {
      if (data.sz > 0) {
        const int sent = dav1d_send_data(context_, &data);
        if (sent < 0 && sent != DAV1D_ERR(EAGAIN)) {
          dav1d_data_unref(&data);
          dav1d_picture_unref(&shown);
          return damaged();
        }
      }
      Dav1dPicture next{};
      const int got = dav1d_get_picture(context_, &next);
      if (got == 0) {
        dav1d_picture_unref(&shown);
        shown = next;
      } else if (got != DAV1D_ERR(EAGAIN)) {
        dav1d_data_unref(&data);
        dav1d_picture_unref(&shown);
        return damaged();
      } else if (data.sz == 0) {
        break;
      }
    }
    if (shown.data[0] == nullptr) return damaged();
    return checked(
        std::shared_ptr<Dav1dPicture>(new Dav1dPicture(shown), [](Dav1dPicture* picture) {
          dav1d_picture_unref(picture);
          delete picture;
        }));
  }

 private:
  static tl::unexpected<Error> damaged() { return fail("a picture of the video is damaged"); }

  Result<Av1Picture> checked(std::shared_ptr<const Dav1dPicture> picture) const {
    const Dav1dPictureParameters& p = picture->p;
    if (p.w != format_.width || p.h != format_.height || p.bpc != format_.bits ||
        p.layout != DAV1D_PIXEL_LAYOUT_I420)
      return fail(concat("a picture of the video has ", p.w, " x ", p.h, " pixels of ", p.bpc,
                         " bits instead of ", format_.width, " x ", format_.height, " of ",
                         format_.bits));
    Av1Picture views;
    if (format_.bits > 8) {
      views.depth = {static_cast<const std::uint16_t*>(picture->data[0]), picture->stride[0] / 2};
    } else {
      const auto plane = [&](int i) {
        return PlaneView<std::uint8_t>{static_cast<const std::uint8_t*>(picture->data[i]),
                                       picture->stride[i > 0 ? 1 : 0]};
      };
      views.luma = plane(0);
      views.cb = plane(1);
      views.cr = plane(2);
    }
    views.memory = std::move(picture);
    return views;
  }

  Av1Format format_;
  Dav1dContext* context_ = nullptr;
};

void Av1Decoder::Close::operator()(Impl* impl) const { delete impl; }

Result<Av1Decoder> Av1Decoder::open(const Av1Format& format, int threads) {
  Av1Decoder decoder(new Impl(format));
  if (!decoder.impl_->open(threads))
    return fail(ErrorCode::limit, "no decoder of AV1 could be opened");
  return decoder;
}

Result<Av1Picture> Av1Decoder::decode(ByteView temporal_unit) {
  return impl_->decode(temporal_unit);
}

}  // namespace pointreel
