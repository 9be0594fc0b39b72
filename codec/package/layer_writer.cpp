#include "codec/package/layer_writer.h"

#include <cstdint>
#include <system_error>
#include <utility>

#include <fmt/format.h>

namespace pointreel {

LayerWriter::LayerWriter(const std::filesystem::path& folder, const std::string& name)
    : folder_(folder), out_(folder / name, std::ios::binary) {
  file_.path = name;
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
  const auto failed = [this] {
    return fail(ErrorCode::io, (folder_ / file_.path).string() +
                                   ": cannot be written; check that the disk is not full");
  };
  out_.close();
  if (!out_) return failed();
  file_.checksum = checksum_.value();
  const std::string name = fmt::format("{}.{:08x}.prs", file_.path, file_.checksum >> 32);
  std::error_code error;
  std::filesystem::rename(folder_ / file_.path, folder_ / name, error);
  if (error) return failed();
  file_.path = name;
  return std::move(file_);
}

void LayerWriter::write(const Bytes& bytes) {
  out_.write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  checksum_.add(bytes);
  file_.bytes += bytes.size();
}

}  // namespace pointreel
