// Who may include whom (README, "The house"), read from the include lines of all sources.

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace pointreel {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kHouse = {"common", "codec", "server",
                                         "client", "tests", "datasets_synthetic"};

struct Source {
  std::string path;                   // from the root of the repository
  std::string code;                   // without comments and string literals
  std::vector<std::string> includes;  // as written: <vector>, "common/base/error.h"
};

std::string without_comments(const std::string& text) {
  std::string out;
  enum { code, line, block, string, character } state = code;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    const char next = i + 1 < text.size() ? text[i + 1] : '\0';
    switch (state) {
      case code:
        if (c == '/' && next == '/') {
          state = line;
        } else if (c == '/' && next == '*') {
          state = block;
          ++i;
        } else {
          if (c == '"') state = string;
          if (c == '\'' && (i == 0 || !std::isalnum(static_cast<unsigned char>(text[i - 1])))) {
            state = character;  // and not the separator of 1'000
          }
          out += c;
        }
        break;
      case line:
        if (c == '\n') {
          state = code;
          out += c;
        }
        break;
      case block:
        if (c == '*' && next == '/') {
          state = code;
          ++i;
        }
        break;
      case string:
      case character:
        if (c == '\\') {
          ++i;
        } else if (c == (state == string ? '"' : '\'') || c == '\n') {
          state = code;
          out += c;
        }
        break;
    }
  }
  return out;
}

Source parse(const std::string& path, const std::string& text) {
  Source source{path, without_comments(text), {}};
  static const std::regex include(R"re(^\s*#\s*include\s*(<[^>]+>|"[^"]+"))re");
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::smatch match;
    if (std::regex_search(line, match, include)) source.includes.push_back(match[1]);
  }
  return source;
}

std::vector<Source> read_house() {
  std::vector<Source> sources;
  const fs::path root = POINTREEL_SOURCE_DIR;
  for (const std::string& part : kHouse) {
    for (const auto& entry : fs::recursive_directory_iterator(root / part)) {
      const std::string extension = entry.path().extension();
      if (extension != ".h" && extension != ".cpp" && extension != ".c") continue;
      std::ifstream in(entry.path(), std::ios::binary);
      std::stringstream text;
      text << in.rdbuf();
      sources.push_back(parse(fs::relative(entry.path(), root).generic_string(), text.str()));
    }
  }
  std::sort(sources.begin(), sources.end(),
            [](const Source& a, const Source& b) { return a.path < b.path; });
  return sources;
}

std::string top(std::string_view path) { return std::string(path.substr(0, path.find('/'))); }

/// A room is a header with its source beside it: "common/cloud/ply".
std::string room(std::string_view path) { return std::string(path.substr(0, path.rfind('.'))); }

bool in(std::string_view path, std::string_view place) {
  return path == place || (path.starts_with(place) && path.substr(place.size()).starts_with('/'));
}

/// What is wrong with `path` having the include `written`, if anything is.
std::optional<std::string> broken_rule(const std::string& path, const std::string& written) {
  const std::string name = written.substr(1, written.size() - 2);
  const auto starts_with_any = [&](std::initializer_list<std::string_view> prefixes) {
    return std::any_of(prefixes.begin(), prefixes.end(),
                       [&](std::string_view prefix) { return name.starts_with(prefix); });
  };

  if (written.front() == '<') {
    if (in(path, "client/render") && starts_with_any({"curl/", "boost/", "sys/socket", "netdb"})) {
      return "client/render knows nothing of the network";
    }
    if (in(path, "client/playback") &&
        starts_with_any({"epoxy/", "GL/", "GLES", "EGL/", "GLFW/", "imgui"})) {
      return "client/playback knows nothing of OpenGL";
    }
    return std::nullopt;
  }

  const std::string mine = top(path), theirs = top(name);
  if (std::find(kHouse.begin(), kHouse.end(), theirs) == kHouse.end()) {
    return "our own headers are included by their full path from the root";
  }
  static const std::map<std::string, std::set<std::string>> may_include = {
      {"common", {"common"}},
      {"codec", {"common", "codec"}},
      {"server", {"common", "codec", "server"}},
      {"client", {"common", "codec", "client"}},
      {"datasets_synthetic", {"common", "datasets_synthetic"}},
      {"tests", {"common", "codec", "server", "client", "datasets_synthetic", "tests"}},
  };
  if (!may_include.at(mine).contains(theirs)) return mine + " must not include " + theirs;

  // Floors: a room uses only what stands on its own floor or below it.
  static const std::vector<std::vector<std::string>> buildings = {
      {"common/base", "common/cloud", "common/octree", "common/surface", "common/stream"},
      {"client/source", "client/playback", "client/ui"},
      {"client/scene", "client/playback", "client/ui"},
      {"client/scene", "client/render", "client/ui"},
  };
  for (const auto& floors : buildings) {
    int from = -1, to = -1;
    for (int floor = 0; floor < static_cast<int>(floors.size()); ++floor) {
      if (in(path, floors[floor])) from = floor;
      if (in(name, floors[floor])) to = floor;
    }
    if (from >= 0 && to > from) return floors[from] + " stands below " + floors[to];
  }
  static const std::vector<std::pair<std::string, std::string>> strangers = {
      {"client/render", "client/source"},   {"client/render", "client/playback"},
      {"client/scene", "client/source"},    {"client/source", "client/scene"},
      {"client/playback", "client/render"}, {"codec/octree", "codec/draco"},
      {"codec/draco", "codec/octree"},      {"server/pack", "server/serve"},
      {"server/serve", "server/pack"},
  };
  for (const auto& [one, other] : strangers) {
    if (in(path, one) && in(name, other)) return one + " knows nothing of " + other;
  }
  return std::nullopt;
}

/// A path through rooms that leads back to where it starts; empty if there is none.
std::vector<std::string> find_cycle(const std::vector<Source>& sources) {
  std::map<std::string, std::set<std::string>> uses;
  for (const Source& source : sources) {
    for (const std::string& include : source.includes) {
      const std::string name = include.substr(1, include.size() - 2);
      if (include.front() == '"' && room(name) != room(source.path)) {
        uses[room(source.path)].insert(room(name));
      }
    }
  }
  std::set<std::string> done;
  std::vector<std::string> path;
  const std::function<bool(const std::string&)> visit = [&](const std::string& at) {
    if (const auto back = std::find(path.begin(), path.end(), at); back != path.end()) {
      path.erase(path.begin(), back);
      path.push_back(at);
      return true;
    }
    if (done.contains(at)) return false;
    path.push_back(at);
    for (const std::string& next : uses[at]) {
      if (visit(next)) return true;
    }
    path.pop_back();
    done.insert(at);
    return false;
  };
  for (const Source& source : sources) {
    if (visit(room(source.path))) return path;
  }
  return {};
}

/// The sources of the octree codec and of every room that it stands on.
std::vector<const Source*> octree_floor(const std::vector<Source>& sources) {
  std::set<std::string> rooms;
  std::vector<std::string> open;
  const auto reach = [&](const std::string& name) {
    if (rooms.insert(name).second) open.push_back(name);
  };
  for (const Source& source : sources) {
    if (in(source.path, "codec/octree") || in(source.path, "common/octree")) {
      reach(room(source.path));
    }
  }
  while (!open.empty()) {
    const std::string at = open.back();
    open.pop_back();
    for (const Source& source : sources) {
      if (room(source.path) != at) continue;
      for (const std::string& include : source.includes) {
        if (include.front() == '"') reach(room(include.substr(1, include.size() - 2)));
      }
    }
  }
  std::vector<const Source*> floor;
  for (const Source& source : sources) {
    if (rooms.contains(room(source.path))) floor.push_back(&source);
  }
  return floor;
}

/// Why a source cannot be built for WebAssembly without exceptions, threads, files and sockets.
std::vector<std::string> unfit_for_the_browser(const Source& source) {
  static const std::regex forbidden_include(
      "<(thread|stop_token|mutex|shared_mutex|condition_variable|future|semaphore|latch|barrier|"
      "fstream|iostream|filesystem|cstdio|stdio\\.h|unistd\\.h|fcntl\\.h|sys/.*|netinet/.*|"
      "netdb\\.h|arpa/.*|pthread\\.h|tbb/.*|oneapi/.*|boost/.*|curl/.*)>");
  static const std::regex forbidden_word("\\b(throw|try|catch)\\b");
  std::vector<std::string> found;
  for (const std::string& include : source.includes) {
    if (std::regex_match(include, forbidden_include)) found.push_back(include);
  }
  std::smatch word;
  if (std::regex_search(source.code, word, forbidden_word)) found.push_back(word[1]);
  return found;
}

TEST(Dependency, every_source_includes_only_what_its_room_may_include) {
  const std::vector<Source> sources = read_house();
  ASSERT_GT(sources.size(), 10u) << "no sources under " << POINTREEL_SOURCE_DIR;
  for (const Source& source : sources) {
    for (const std::string& include : source.includes) {
      const auto broken = broken_rule(source.path, include);
      EXPECT_FALSE(broken) << source.path << " includes " << include << ": " << broken.value_or("");
    }
  }
}

TEST(Dependency, every_header_of_ours_that_is_included_exists) {
  for (const Source& source : read_house()) {
    for (const std::string& include : source.includes) {
      if (include.front() != '"') continue;
      const fs::path header =
          fs::path(POINTREEL_SOURCE_DIR) / include.substr(1, include.size() - 2);
      EXPECT_TRUE(fs::exists(header)) << source.path << " includes " << include;
    }
  }
}

TEST(Dependency, no_two_rooms_use_each_other) {
  const std::vector<std::string> cycle = find_cycle(read_house());
  EXPECT_THAT(cycle, testing::IsEmpty());
}

TEST(Dependency, the_floor_of_the_octree_codec_needs_no_exceptions_threads_files_or_sockets) {
  const std::vector<Source> sources = read_house();
  const auto floor = octree_floor(sources);
  ASSERT_FALSE(floor.empty());
  for (const Source* source : floor) {
    EXPECT_THAT(unfit_for_the_browser(*source), testing::IsEmpty()) << source->path;
  }
}

TEST(Dependency, a_forbidden_include_is_noticed) {
  const auto breaks = [](const char* path, const char* include) {
    return broken_rule(path, include).has_value();
  };
  EXPECT_TRUE(breaks("common/cloud/ply.cpp", "\"codec/codec.h\""));
  EXPECT_TRUE(breaks("common/cloud/ply.cpp", "\"common/octree/svo.h\""));
  EXPECT_TRUE(breaks("common/cloud/ply.cpp", "\"ply.h\""));
  EXPECT_TRUE(breaks("codec/codec.h", "\"client/scene/frame.h\""));
  EXPECT_TRUE(breaks("server/pack/packer.cpp", "\"client/scene/frame.h\""));
  EXPECT_TRUE(breaks("client/source/file.cpp", "\"server/serve/http_server.h\""));
  EXPECT_TRUE(breaks("client/main.cpp", "\"tests/support.h\""));
  EXPECT_TRUE(breaks("datasets_synthetic/main.cpp", "\"codec/codec.h\""));
  EXPECT_TRUE(breaks("client/render/renderer.cpp", "\"client/source/source.h\""));
  EXPECT_TRUE(breaks("client/render/renderer.cpp", "\"client/playback/clock.h\""));
  EXPECT_TRUE(breaks("client/render/methods/a.cpp", "<curl/curl.h>"));
  EXPECT_TRUE(breaks("client/playback/pipeline.cpp", "<epoxy/gl.h>"));
  EXPECT_TRUE(breaks("client/playback/pipeline.cpp", "<GLFW/glfw3.h>"));
  EXPECT_TRUE(breaks("client/playback/pipeline.cpp", "\"client/render/renderer.h\""));

  EXPECT_FALSE(breaks("common/octree/svo.cpp", "\"common/cloud/geometry.h\""));
  EXPECT_FALSE(breaks("client/render/renderer.cpp", "<epoxy/gl.h>"));
  EXPECT_FALSE(breaks("client/player.cpp", "\"client/render/renderer.h\""));
  EXPECT_FALSE(breaks("tests/unit/a_test.cpp", "\"server/pack/packer.h\""));
}

TEST(Dependency, a_circle_of_rooms_is_noticed) {
  const std::vector<Source> circle = {
      parse("a/one.h", "#include \"a/two.h\"\n"),
      parse("a/two.h", ""),
      parse("a/two.cpp", "#include \"a/two.h\"\n#include \"a/three.h\"\n"),
      parse("a/three.h", "  #  include \"a/one.h\"\n"),
  };
  EXPECT_THAT(find_cycle(circle), testing::SizeIs(4));
  EXPECT_THAT(find_cycle({circle[0], circle[1], circle[2]}), testing::IsEmpty());
}

TEST(Dependency, what_a_browser_cannot_have_is_noticed_in_code_and_not_in_comments) {
  const auto unfit = [](const char* text) { return unfit_for_the_browser(parse("a.cpp", text)); };
  EXPECT_THAT(unfit("#include <thread>\n#include <vector>\n"), testing::ElementsAre("<thread>"));
  EXPECT_THAT(unfit("#include <sys/socket.h>\n"), testing::SizeIs(1));
  EXPECT_THAT(unfit("void f() { throw 1; }\n"), testing::ElementsAre("throw"));
  EXPECT_THAT(unfit("// never throw\n/* try */ const char* s = \"catch\"; int throws = 1'000;\n"),
              testing::IsEmpty());
}

TEST(Dependency, what_the_octree_codec_stands_on_is_followed_through_headers_to_their_sources) {
  const std::vector<Source> sources = {
      parse("codec/octree/a.cpp", "#include \"common/cloud/b.h\"\n"),
      parse("common/cloud/b.h", ""),
      parse("common/cloud/b.cpp", "#include \"common/base/c.h\"\n"),
      parse("common/base/c.h", ""),
      parse("common/base/other.h", ""),
  };
  std::vector<std::string> paths;
  for (const Source* source : octree_floor(sources)) paths.push_back(source->path);
  EXPECT_THAT(paths, testing::ElementsAre("codec/octree/a.cpp", "common/cloud/b.h",
                                          "common/cloud/b.cpp", "common/base/c.h"));
}

}  // namespace
}  // namespace pointreel
