#include "server/pack/package_tables.h"

#include <utility>
#include <vector>

#include "codec/package/layer_writer.h"
#include "codec/training/sequence_tables.h"
#include "common/base/try.h"
#include "common/file_system/output_folder.h"
#include "server/pack/sample_trees.h"

namespace pointreel {

Result<PackageTables> learn_package_tables(std::span<const CloudFrame> files, PackOptions& options,
                                           const std::filesystem::path& folder,
                                           const std::stop_token& stop) {
  Result<std::vector<Svo>> sampled = sample_trees(files, options, stop);
  if (stop.stop_requested()) return fail(ErrorCode::cancelled, kInterrupted);
  const std::vector<Svo> samples = TRY(std::move(sampled));
  const SequenceTables learnt = TRY(learn_tables(samples, files.size()));
  PackageTables tables{{samples.size(), learnt.file.size(), learnt.saved_bytes}, {}};
  if (learnt.file.empty()) return tables;
  std::get<OctreeOptions>(options.encode.codec).tables = TRY(read_table_file(learnt.file));
  LayerWriter writer(folder, "tables");
  writer.append({learnt.file, {}, {}});
  tables.file = TRY(writer.finish());
  return tables;
}

}  // namespace pointreel
