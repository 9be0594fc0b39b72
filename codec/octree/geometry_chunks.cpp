#include "codec/octree/geometry_chunks.h"

#include <bit>

#include "codec/octree/chunk_payload.h"
#include "codec/octree/context_tables.h"
#include "common/base/byte_io.h"
#include "common/base/concat.h"
#include "common/base/try.h"

namespace pointreel {

Result<GeometryEncoder> GeometryEncoder::create(Entropy entropy,
                                                const std::shared_ptr<const ContextTables>& tables,
                                                int slabs) {
  GeometryEncoder encoder;
  if (entropy != Entropy::context) return encoder;
  ByteWriter name(encoder.tables_name_);
  if (tables) {
    name.put(kGivenTables);
    name.put(tables->checksum);
    encoder.context_.emplace(tables, slabs);
    return encoder;
  }
  name.put(kNewestTables);
  encoder.context_.emplace(TRY(tables_of_number(kNewestTables)), slabs);
  return encoder;
}

void GeometryEncoder::encode_layer(const Svo& svo, int first_level, ChunkHeader header,
                                   FrameTag tag, const Executor& executor, Bytes& out) {
  const std::size_t begin = svo.level_begin[static_cast<std::size_t>(first_level)];
  const std::size_t end = svo.level_begin[header.last_level];
  const ByteView masks = ByteView(svo.masks).subspan(begin, end - begin);
  if (!context_ || masks.empty()) {
    if (header.entropy == Entropy::context) header.entropy = Entropy::none;
    pack_chunk(header, tag, masks, out);
    return;
  }
  Bytes payload;
  if (header.layer == 0) payload = tables_name_;
  context_->encode_layer(svo, first_level, header.last_level, payload, executor);
  // Appends zeros where the payload would expand further than readers accept.
  while (max_raw_size(payload.size()) < masks.size()) {
    payload.resize(static_cast<std::size_t>((masks.size() - max_raw_size(0) + 1023) / 1024));
  }
  header.raw_size = static_cast<std::uint32_t>(masks.size());
  write_chunk(header, tag, payload, out);
}

Result<void> GeometryDecoder::decode_layer(const ParsedChunk& chunk, int first_level,
                                           const Executor& executor, MemoryBudget& budget,
                                           Bytes& masks) {
  // A tree has at most as many nodes on a level as it has leaves.
  const int levels = chunk.header.last_level - first_level;
  if (chunk.header.raw_size > std::uint64_t{points_} * static_cast<unsigned>(levels)) {
    return fail("chunk holds more nodes than the frame can have");
  }
  const std::size_t begin = masks.size();
  if (chunk.header.entropy == Entropy::context) {
    TRY(decode_context(chunk, first_level, executor, budget, masks));
  } else {
    if (context_) return fail("chunk has another entropy coding than the layers before it");
    const Bytes raw = TRY(unpack_chunk(chunk, chunk.header.raw_size));
    masks.insert(masks.end(), raw.begin(), raw.end());
  }
  return count_nodes(ByteView(masks).subspan(begin), levels);
}

Result<void> GeometryDecoder::decode_context(const ParsedChunk& chunk, int first_level,
                                             const Executor& executor, MemoryBudget& budget,
                                             Bytes& masks) {
  ByteView payload = chunk.payload;
  if (chunk.header.raw_size == 0 || chunk.header.raw_size > max_raw_size(payload.size())) {
    return fail(concat("chunk cannot hold ", chunk.header.raw_size, " masks in ", payload.size(),
                       " bytes"));
  }
  if (chunk.header.layer == 0) {
    context_.emplace(TRY(take_tables(payload)));
  }
  if (!context_) return fail("chunk has another entropy coding than the layers before it");
  return context_->decode_layer(payload, first_level, chunk.header.last_level,
                                chunk.header.raw_size, points_, masks, executor, &budget);
}

Result<std::shared_ptr<const ContextTables>> GeometryDecoder::take_tables(ByteView& payload) const {
  ByteReader reader(payload);
  const auto number = reader.get<std::uint8_t>();
  const auto checksum = number == kGivenTables ? reader.get<std::uint64_t>() : 0;
  if (!reader.ok()) return fail("chunk is cut short");
  payload = reader.rest();
  if (number != kGivenTables) return tables_of_number(number);
  if (given_tables_ == nullptr) {
    return fail(ErrorCode::not_found,
                "frame needs the context tables of its package, which are not there");
  }
  if (given_tables_->checksum != checksum) {
    return fail("frame needs other context tables than those of its package");
  }
  return std::shared_ptr<const ContextTables>(std::shared_ptr<void>(), given_tables_);
}

Result<void> GeometryDecoder::count_nodes(ByteView masks, int levels) {
  std::size_t at = 0;
  for (int level = 0; level < levels; ++level) {
    if (level_nodes_ > masks.size() - at) return fail("level sizes disagree with the masks");
    std::uint64_t children = 0;
    for (const std::size_t end = at + level_nodes_; at < end; ++at) {
      children += static_cast<unsigned>(std::popcount(masks[at]));
    }
    if (children > points_) return fail("more nodes than the header has points");
    level_nodes_ = static_cast<std::size_t>(children);
  }
  if (at != masks.size()) return fail("level sizes disagree with the masks");
  return {};
}

}  // namespace pointreel
