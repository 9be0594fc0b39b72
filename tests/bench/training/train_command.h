#pragma once

namespace CLI {
class App;
}

/// The command `pointreel-bench train-context`.
namespace pointreel::bench {

/// Trains context tables from synthetic data and writes them, compressed, to a file: what
/// codec/octree/tables holds. The command sets `exit_code` once it has run: 0, or 1 if the file
/// cannot be written.
void add_train_command(CLI::App& app, int& exit_code);

}  // namespace pointreel::bench
