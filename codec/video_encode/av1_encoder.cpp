#include "codec/video_encode/av1_encoder.h"

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <utility>

#include <sched.h>
#include <svt-av1/EbSvtAv1Enc.h>

#include "common/base/concat.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

/// Before there are threads: the library prints about itself unless its environment says otherwise,
/// and has no other way to stop it. 1 leaves errors.
[[maybe_unused]] const int kQuiet = setenv("SVT_LOG", "1", 0);

/// As root, the library gives its threads the highest priority of real time, with which they keep
/// all other programs, and the rest of this one, from the processors.
void give_up_real_time() {
  std::error_code none;
  for (const auto& thread : std::filesystem::directory_iterator("/proc/self/task", none)) {
    const pid_t id = std::atoi(thread.path().filename().c_str());
    const sched_param usual{};
    if (sched_getscheduler(id) == SCHED_FIFO) sched_setscheduler(id, SCHED_OTHER, &usual);
  }
}

/// An encoder, which is closed at the end.
class Encoder {
 public:
  Encoder() = default;
  Encoder(const Encoder&) = delete;
  Encoder& operator=(const Encoder&) = delete;
  ~Encoder() {
    if (begun_) svt_av1_enc_deinit(handle_);
    if (handle_ != nullptr) svt_av1_enc_deinit_handle(handle_);
  }

  Result<void> open(const Av1Options& options) {
    EbSvtAv1EncConfiguration settings{};
    if (svt_av1_enc_init_handle(&handle_, nullptr, &settings) != EB_ErrorNone)
      return failed("be opened");
    settings.enc_mode = static_cast<std::int8_t>(options.preset);
    settings.source_width = static_cast<std::uint32_t>(options.width);
    settings.source_height = static_cast<std::uint32_t>(options.height);
    settings.encoder_bit_depth = static_cast<std::uint32_t>(options.bits);
    settings.encoder_color_format = EB_YUV420;
    settings.frame_rate_numerator = 30;
    settings.frame_rate_denominator = 1;
    settings.rate_control_mode = 0;
    // It saves bits where there is much to see, of which depth knows nothing.
    settings.enable_adaptive_quantization = options.bits == 8 ? 2 : 0;
    settings.qp = static_cast<std::uint32_t>(options.quantizer);
    settings.intra_period_length = options.frames - 1;
    settings.intra_refresh_type = SVT_AV1_KF_REFRESH;  // closed groups
    settings.tune = 1;                                 // errors, not looks
    settings.enable_overlays = 0;
    settings.enable_tf = options.bits == 8;  // it mixes pictures, and with them places
    settings.film_grain_denoise_strength = 0;
    settings.scene_change_detection = 0;
    settings.logical_processors = static_cast<std::uint32_t>(options.threads);
    settings.color_range = EB_CR_FULL_RANGE;
    settings.color_description_present_flag = 1;
    settings.matrix_coefficients = EB_CICP_MC_BT_709;
    settings.color_primaries = EB_CICP_CP_BT_709;
    settings.transfer_characteristics = EB_CICP_TC_SRGB;
    if (svt_av1_enc_set_parameter(handle_, &settings) != EB_ErrorNone)
      return failed("take these options");
    if (svt_av1_enc_init(handle_) != EB_ErrorNone) {
      // Where memory is short, releasing it would wait for threads that never began (1.4.1).
      handle_ = nullptr;
      return failed("start");
    }
    begun_ = true;
    give_up_real_time();
    return {};
  }

  Result<void> send(const Av1Options& options, int i, Yuv& picture) {
    const auto width = static_cast<std::uint32_t>(options.width);
    EbSvtIOFormat planes{};
    planes.luma = picture.luma.data();
    planes.cb = picture.cb.data();
    planes.cr = picture.cr.data();
    planes.y_stride = width;
    planes.cb_stride = planes.cr_stride = width / 2;
    planes.width = width;
    planes.height = static_cast<std::uint32_t>(options.height);
    planes.color_fmt = EB_YUV420;
    planes.bit_depth = options.bits > 8 ? EB_TEN_BIT : EB_EIGHT_BIT;
    EbBufferHeaderType header{};
    header.size = sizeof(header);
    header.p_buffer = reinterpret_cast<std::uint8_t*>(&planes);
    header.n_filled_len =
        static_cast<std::uint32_t>(picture.luma.size() + picture.cb.size() + picture.cr.size());
    header.n_alloc_len = header.n_filled_len;
    header.pts = i;
    header.pic_type = EB_AV1_INVALID_PICTURE;
    if (svt_av1_enc_send_picture(handle_, &header) != EB_ErrorNone) return failed("take a picture");
    return {};
  }

  Result<void> end() {
    EbBufferHeaderType header{};
    header.size = sizeof(header);
    header.flags = EB_BUFFERFLAG_EOS;
    header.pic_type = EB_AV1_INVALID_PICTURE;
    if (svt_av1_enc_send_picture(handle_, &header) != EB_ErrorNone) return failed("end");
    return {};
  }

  /// Takes what is ready; all of the rest, if no more pictures come.
  Result<void> receive(bool rest, std::vector<Bytes>& units) {
    while (true) {
      EbBufferHeaderType* packet = nullptr;
      const EbErrorType got = svt_av1_enc_get_packet(handle_, &packet, rest ? 1 : 0);
      if (got == EB_NoErrorEmptyQueue) return {};
      if (got != EB_ErrorNone) return failed("give a picture");
      const bool last = (packet->flags & EB_BUFFERFLAG_EOS) != 0;
      if (packet->n_filled_len > 0)
        units.emplace_back(packet->p_buffer, packet->p_buffer + packet->n_filled_len);
      svt_av1_enc_release_out_buffer(&packet);
      if (last) return {};
    }
  }

 private:
  static tl::unexpected<Error> failed(const char* what) {
    return fail(ErrorCode::limit, concat(av1_encoder_name(), " could not ", what));
  }

  EbComponentType* handle_ = nullptr;
  bool begun_ = false;
};

}  // namespace

std::string av1_encoder_name() { return concat("SVT-AV1 ", svt_av1_get_version()); }

Result<std::vector<Bytes>> encode_av1(const Av1Options& options,
                                      const std::function<void(int, Yuv&)>& picture) {
  Encoder encoder;
  TRY(encoder.open(options));
  std::vector<Bytes> units;
  const std::size_t luma = static_cast<std::size_t>(options.width) *
                           static_cast<std::size_t>(options.height) * (options.bits > 8 ? 2 : 1);
  Yuv planes{Bytes(luma), Bytes(luma / 4), Bytes(luma / 4)};
  for (int i = 0; i < options.frames; ++i) {
    picture(i, planes);
    TRY(encoder.send(options, i, planes));
    TRY(encoder.receive(false, units));
  }
  TRY(encoder.end());
  TRY(encoder.receive(true, units));
  if (units.size() != static_cast<std::size_t>(options.frames))
    return fail(
        concat(av1_encoder_name(), " gave ", units.size(), " of ", options.frames, " pictures"));
  return units;
}

}  // namespace pointreel
