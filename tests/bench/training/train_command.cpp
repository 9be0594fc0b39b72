#include "tests/bench/training/train_command.h"

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>

#include <fmt/format.h>
#include <zstd.h>

#include "codec/training/context_trainer.h"
#include "common/command_line/command.h"
#include "common/process/print.h"
#include "tests/bench/measure.h"
#include "tests/bench/training/training_clouds.h"

namespace pointreel::bench {
namespace {

struct Options {
  std::filesystem::path output;
  std::uint64_t seed = 1;
  TrainingOptions training;
};

int train(const Options& options) {
  const double begin = now_ms();
  ContextTrainer trainer;
  const auto made =
      for_each_training_tree(options.seed, [&](const std::string& name, const Svo& svo) {
        trainer.add(svo);
        print("{:<28} {:>9} cells {:>9} nodes\n", name, svo.leaf_count(), svo.internal_count());
      });
  if (!made) {
    print_error("pointreel-bench", made.error().message);
    return 1;
  }
  print("{} symbols after {:.0f} s\n", trainer.sample_count(), (now_ms() - begin) / 1e3);
  const ContextTrainer::Result result = trainer.train(options.training);
  const Bytes tables = write_tables(result.tables);
  Bytes packed(ZSTD_compressBound(tables.size()));
  packed.resize(
      ZSTD_compress(packed.data(), packed.size(), tables.data(), tables.size(), ZSTD_maxCLevel()));
  std::ofstream file(options.output, std::ios::binary);
  file.write(reinterpret_cast<const char*>(packed.data()),
             static_cast<std::streamsize>(packed.size()));
  file.close();
  if (!file) {
    print_error("pointreel-bench", options.output.string() + ": cannot be written");
    return 1;
  }
  print("{} cells, {} alphabets, {:.4f} bits per symbol, {} bytes, {:.0f} s\n", result.cells,
        result.alphabets, result.bits_per_symbol, packed.size(), (now_ms() - begin) / 1e3);
  return 0;
}

}  // namespace

void add_train_command(cli::Command app, int& exit_code) {
  const cli::Command command = app.add_subcommand(
      "train-context", "training the tables of --entropy context from synthetic data");
  command.footer(
      "The same seed gives the same tables. codec/octree/tables/README.md says how to install "
      "them.");
  auto options = std::make_shared<Options>();
  command.add_option("-o,--output", options->output, "the file to write")
      .required()
      .type_name("FILE");
  command.add_option("--seed", options->seed, "seed of the synthetic data").capture_default_str();
  command
      .add_option("--alphabet-cost", options->training.alphabet_cost,
                  "bits that each alphabet must save; a higher cost gives smaller tables")
      .check(cli::positive_number())
      .capture_default_str();
  command.callback([options, &exit_code] { exit_code = train(*options); });
}

}  // namespace pointreel::bench
