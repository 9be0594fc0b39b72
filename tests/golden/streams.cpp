#include "tests/golden/streams.h"

#include <span>

#include "common/base/byte_io.h"
#include "common/base/try.h"
#include "common/file_system/write_file.h"
#include "pointreel/chunks.h"
#include "pointreel/draco.h"
#include "tests/golden/cells.h"
#include "tests/golden/hash.h"
#include "tests/golden/known_as_number.h"

namespace pointreel::golden {
namespace {

nlohmann::json decoded(const EncodedFrame& encoded, std::size_t layers) {
  auto views = layer_views(encoded.layers);
  views.resize(layers);
  const auto frame = decode_frame(views);
  if (!frame) return {{"error", name(frame.error().code)}};
  const int depth = frame->svo ? frame->svo->depth : encoded.layers.front().geometry[6];
  nlohmann::json out = {
      {"depth", depth}, {"points", frame->cloud.size()}, {"cells", hash(cells_of(*frame, depth))}};
  if (frame->cloud.has_colors()) out["colors"] = hash(frame->cloud.colors);
  for (const ScalarField& field : frame->cloud.scalars)
    out["scalars"][field.name] = hash(known_as_number(field.values));
  if (frame->cloud.has_normals()) out["normals"] = hash(frame->cloud.normals);
  return out;
}

}  // namespace

nlohmann::json outcome(const EncodedFrame& frame) {
  nlohmann::json whole = decoded(frame, frame.layers.size());
  if (whole.contains("error")) return whole;
  nlohmann::json prefixes = nlohmann::json::array();
  for (std::size_t layers = 1; layers < frame.layers.size(); ++layers) {
    prefixes.push_back(decoded(frame, layers));
  }
  prefixes.push_back(std::move(whole));
  return {{"layers", prefixes}};
}

Bytes file_of(const EncodedFrame& frame) {
  Bytes file;
  ByteWriter writer(file);
  writer.put(static_cast<std::uint32_t>(frame.layers.size()));
  for (const Chunks<Bytes>& layer : frame.layers) {
    for (const Bytes* chunk : {&layer.geometry, &layer.colors, &layer.normals}) {
      writer.put(static_cast<std::uint32_t>(chunk->size()));
      file.insert(file.end(), chunk->begin(), chunk->end());
    }
  }
  return file;
}

Result<EncodedFrame> frame_of(ByteView file) {
  EncodedFrame frame;
  ByteReader reader(file);
  const auto layers = reader.get<std::uint32_t>();
  for (std::uint32_t i = 0; i < layers && reader.ok(); ++i) {
    Chunks<Bytes>& layer = frame.layers.emplace_back();
    for (Bytes* chunk : {&layer.geometry, &layer.colors, &layer.normals}) {
      const auto size = reader.get<std::uint32_t>();
      const ByteView rest = reader.rest();
      if (size > rest.size()) return fail("the file is cut short");
      chunk->assign(rest.begin(), rest.begin() + size);
      reader = ByteReader(rest.subspan(size));
    }
  }
  if (!reader.ok() || !reader.rest().empty()) return fail("the file does not hold a stream");
  return frame;
}

Result<void> write_streams(const std::filesystem::path& folder) {
  nlohmann::json outcomes;
  for (const auto make : {good_streams, changed_streams}) {
    const std::vector<Stream> streams = TRY(make());
    for (const Stream& stream : streams) {
      outcomes[stream.name] = outcome(stream.frame);
      const bool bad = stream.name.starts_with("bad_");
      if (outcomes[stream.name].contains("error") != bad) {
        return fail(stream.name + (bad ? ": decodes" : ": does not decode"));
      }
      TRY(write_file(folder / (stream.name + ".frame"), file_of(stream.frame)));
    }
  }
  return write_file(folder / "outcomes.json", outcomes.dump(1) + "\n");
}

}  // namespace pointreel::golden
