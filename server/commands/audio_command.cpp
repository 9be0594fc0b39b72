#include <memory>
#include <optional>
#include <string>

#include "common/base/words.h"
#include "common/process/stop_signal.h"
#include "server/commands/commands.h"
#include "server/pack/audio.h"

namespace pointreel {
namespace {

struct AudioArguments {
  std::string reel, source;
  bool remove = false;
};

int run_audio(const AudioArguments& arguments) {
  if (arguments.remove != arguments.source.empty()) {
    print_error("audio: give either a FILE or --remove");
    return kExitUsage;
  }
  std::optional<std::filesystem::path> source;
  if (!arguments.remove) source = arguments.source;
  const StopSignal stop;
  const auto audio =
      replace_audio(arguments.reel, source, stop.token(),
                    [](const std::string& line) { print_error("warning: " + line); });
  if (!audio) {
    print_error(audio.error().message);
    return audio.error().code == ErrorCode::not_found ? kExitUsage : kExitFailed;
  }
  if (*audio) {
    print("{}: {} s of sound, {}\n", arguments.reel,
          number_text(static_cast<double>((*audio)->samples) / kAudioRate),
          counted((*audio)->bytes, "byte"));
  } else {
    print("{}: no sound\n", arguments.reel);
  }
  return kExitOk;
}

}  // namespace

void add_audio_command(cli::Command app, int& exit_code) {
  const auto a = std::make_shared<AudioArguments>();
  const cli::Command command =
      app.add_subcommand("audio", "Give a package sound, replace its sound, or remove it");
  command.add_option("REEL", a->reel, "the folder of the package").required().type_name("");
  command
      .add_option("FILE", a->source,
                  "any file that ffmpeg reads and that has sound, a video too, but no playlist; "
                  "what is longer than the reel is cut off")
      .type_name("");
  command.add_flag("--remove", a->remove, "leave the package without sound");
  command.callback([a, &exit_code] { exit_code = run_audio(*a); });
}

}  // namespace pointreel
