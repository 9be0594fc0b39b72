#include <filesystem>
#include <memory>

#include "common/base/words.h"
#include "server/commands/commands.h"
#include "server/service/write_page.h"

namespace pointreel {

void add_page_command(cli::Command app, int& exit_code, std::span<const PageFile> page) {
  struct Arguments {
    std::filesystem::path folder;
    bool force = false;
  };
  const auto a = std::make_shared<Arguments>();
  const cli::Command command = app.add_subcommand(
      "page",
      "Write the page that plays packages into a folder of packages, for any web server\n"
      "Upload or serve the folder as it is: index.html lists the packages that are in it by now, "
      "and plays them. Run this again when packages have come or gone.");
  command.add_option("FOLDER", a->folder, "the folder that holds the packages")
      .required()
      .type_name("");
  command.add_flag("--force", a->force, "replace an index.html that is another page");
  command.callback([a, page, &exit_code] {
    const Result<WrittenPage> written = write_page(a->folder, page, a->force);
    if (!written) {
      exit_code = failed_to_open(written.error());
      return;
    }
    for (const std::string& fault : written->faults) print_error("warning: " + fault);
    print("{}: {}\n", (a->folder / "index.html").string(), counted(written->packages, "package"));
    exit_code = kExitOk;
  });
}

}  // namespace pointreel
