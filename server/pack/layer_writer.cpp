#include "server/pack/layer_writer.h"

#include <cstdint>
#include <utility>

namespace pointreel {

LayerWriter::LayerWriter(const std::filesystem::path& folder, const std::string& name)
    : out_(folder / name, std::ios::binary), hash_(XXH3_createState()) {
  file_.path = name;
  XXH3_64bits_reset(hash_.get());
}

void LayerWriter::append(const EncodedLayer& layer) {
  write(layer.geometry);
  write(layer.colors);
  write(layer.normals);
  file_.frames.push_back({static_cast<std::uint32_t>(layer.geometry.size()),
                          static_cast<std::uint32_t>(layer.colors.size()),
                          static_cast<std::uint32_t>(layer.normals.size())});
}

Result<LayerFile> LayerWriter::finish() {
  out_.close();
  if (!out_) {
    return fail(file_.path + ": cannot be written, is there room on the disk?");
  }
  file_.checksum = XXH3_64bits_digest(hash_.get());
  return std::move(file_);
}

void LayerWriter::write(const Bytes& bytes) {
  out_.write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  XXH3_64bits_update(hash_.get(), bytes.data(), bytes.size());
  file_.bytes += bytes.size();
}

}  // namespace pointreel
