#include "codec/package/layer_writer.h"

#include <cerrno>
#include <cstdint>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "common/file_system/write_file.h"

namespace pointreel {

LayerWriter::LayerWriter(const std::filesystem::path& folder, const std::string& name)
    : folder_(folder), out_(folder / name, std::ios::binary) {
  file_.path = name;
  note_error();
}

void LayerWriter::append(const Chunks<Bytes>& layer) {
  write(layer.geometry);
  write(layer.colors);
  write(layer.normals);
  file_.frames.push_back({static_cast<std::uint32_t>(layer.geometry.size()),
                          static_cast<std::uint32_t>(layer.colors.size()),
                          static_cast<std::uint32_t>(layer.normals.size())});
}

Result<LayerFile> LayerWriter::finish() {
  const auto failed = [this](int error) {
    return fail(ErrorCode::io,
                fmt::format("{}: cannot be written: {}", (folder_ / file_.path).string(),
                            why_not_written(error)));
  };
  out_.close();
  note_error();
  if (error_ != 0) return failed(error_);
  file_.checksum = checksum_.value();
  const std::string name = fmt::format("{}.{:08x}.prs", file_.path, file_.checksum >> 32);
  std::error_code error;
  std::filesystem::rename(folder_ / file_.path, folder_ / name, error);
  if (error) return failed(error.value());
  file_.path = name;
  return std::move(file_);
}

void LayerWriter::note_error() {
  if (!out_ && error_ == 0) error_ = errno != 0 ? errno : EIO;
}

void LayerWriter::write(const Bytes& bytes) {
  out_.write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  note_error();
  checksum_.add(bytes);
  file_.bytes += bytes.size();
}

}  // namespace pointreel
