#include "server/service/catalog.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <map>
#include <mutex>
#include <set>
#include <unordered_map>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <sys/stat.h>
#include <unistd.h>

#include "codec/package/manifest.h"
#include "common/base/natural_order.h"
#include "common/base/running_checksum.h"
#include "common/base/try.h"
#include "common/base/words.h"
#include "common/file_system/open_file.h"
#include "pointreel/package.h"
#include "server/service/entity_tag.h"
#include "server/service/request_target.h"

namespace pointreel {
namespace {

namespace fs = std::filesystem;

constexpr const char* kJson = "application/json";

FileIdentity identity_of(const struct stat& status) {
  const auto ns = [](const timespec& t) {
    return std::int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec;
  };
  return {status.st_dev, status.st_ino, static_cast<std::uint64_t>(status.st_size),
          ns(status.st_mtim), ns(status.st_ctim)};
}

/// Whether the content of the open file has the size and the checksum of the resource.
bool has_content(int file, const Resource& resource) {
  RunningChecksum checksum;
  std::vector<std::uint8_t> piece(1u << 20);
  std::uint64_t size = 0;
  for (ssize_t got = 0;
       (got = ::pread(file, piece.data(), piece.size(), static_cast<off_t>(size)));) {
    if (got < 0) return false;
    checksum.add({piece.data(), static_cast<std::size_t>(got)});
    size += static_cast<std::uint64_t>(got);
    if (size > resource.size) return false;
  }
  return size == resource.size && checksum.value() == resource.checksum;
}

/// Whether the file is right, which is found out once for each identity. With the lock held.
bool is_right(KnownFile& known, int file, const Resource& resource) {
  struct stat status{};
  if (::fstat(file, &status) != 0 || !S_ISREG(status.st_mode)) return false;
  if (status.st_nlink == 0) return false;  // removed, or another was put in its place
  const FileIdentity identity = identity_of(status);
  if (identity == known.right) return true;
  if (identity.size != resource.size || known.wrong == identity) return false;
  const bool right = has_content(file, resource);
  if (right) {
    known.right = identity;
  } else {
    known.wrong = identity;
  }
  return right;
}

/// The name of a folder may not be UTF-8, but JSON must be.
std::string text_of(const nlohmann::ordered_json& json) {
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

bool is_odd(char c) { return c == '\\' || c == 0x7f || static_cast<unsigned char>(c) < 0x20; }

Error unusable_name(const fs::path& folder) {
  return {folder.string() + ": the folder's name cannot be used in a URL; rename it",
          ErrorCode::argument};
}

/// The name of a folder, if it can be part of a URL.
Result<std::string> segment_name(const fs::path& folder) {
  std::error_code error;
  const fs::path absolute = fs::absolute(folder, error);
  if (error) return fail(ErrorCode::io, fmt::format("{}: {}", folder.string(), error.message()));
  fs::path normal = absolute.lexically_normal();
  if (!normal.has_filename()) normal = normal.parent_path();  // "reel/"
  std::string name = normal.filename().string();
  if (name.empty() || name == "." || name == ".." || std::ranges::any_of(name, is_odd))
    return tl::unexpected(unusable_name(folder));
  return name;
}

/// The path of a package's file, if it is a regular file inside the package's folder.
Result<fs::path> file_inside(const fs::path& folder, const std::string& name) {
  if (name.empty() || name == "." || name == ".." || name.find('/') != std::string::npos) {
    return fail(fmt::format("the manifest names a file '{}' outside the package", name));
  }
  std::error_code error;
  const fs::path file = fs::canonical(folder / name, error);
  if (error) {
    return fail(fmt::format("{}: {}; pack it again", name, error.message()));
  }
  const auto [end, rest] = std::mismatch(folder.begin(), folder.end(), file.begin(), file.end());
  if (end != folder.end() || rest == file.end()) {
    return fail(fmt::format("{}: is a symbolic link that leads out of the package to {}", name,
                            file.string()));
  }
  if (!fs::is_regular_file(file, error))
    return fail(fmt::format("{}: is not a regular file", name));
  return file;
}

Result<Resource> file_resource(const fs::path& folder, const PackageFile& listed,
                               std::string content_type) {
  const fs::path file = TRY(file_inside(folder, listed.path));
  struct stat status{};
  if (::stat(file.c_str(), &status) != 0 || ::access(file.c_str(), R_OK) != 0) {
    return fail(ErrorCode::io,
                fmt::format("{}: {}", listed.path, std::generic_category().message(errno)));
  }
  if (static_cast<std::uint64_t>(status.st_size) != listed.bytes) {
    return fail(fmt::format("{}: has {}, the manifest says {}; pack it again", listed.path,
                            counted(static_cast<std::uint64_t>(status.st_size), "byte"),
                            listed.bytes));
  }
  Resource resource;
  resource.kind = Resource::Kind::kFile;
  resource.content_type = std::move(content_type);
  resource.cache_control = kImmutable;
  resource.etag = make_etag(listed.checksum);
  resource.file = file;
  resource.size = listed.bytes;
  resource.checksum = listed.checksum;
  resource.known = std::make_shared<KnownFile>();
  resource.known->right = identity_of(status);
  return resource;
}

}  // namespace

FileHandle::~FileHandle() { ::close(descriptor_); }

tl::expected<SharedFile, OpenError> open_resource(const Resource& resource) {
  KnownFile& known = *resource.known;
  const std::lock_guard lock(known.mutex);
  SharedFile file = known.open.lock();
  if (file && is_right(known, file->get(), resource)) return file;
  const int opened = ::open(resource.file.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  if (opened < 0) {
    const bool busy = errno == EMFILE || errno == ENFILE || errno == ENOMEM;
    return tl::unexpected(busy ? OpenError::kBusy : OpenError::kChanged);
  }
  file = std::make_shared<const FileHandle>(opened);
  if (!is_right(known, opened, resource)) return tl::unexpected(OpenError::kChanged);
  known.open = file;
  return file;
}

/// What the state of a catalog consists of.
namespace catalog {

/// A package as it was read.
struct Package {
  FileIdentity manifest;  ///< the file, and that of the journal beside it
  FileIdentity journal;
  std::vector<std::pair<std::string, std::shared_ptr<const Resource>>> entries;
  nlohmann::ordered_json listing;
};
using Packages = std::map<std::string, std::shared_ptr<const Package>>;  // by name

/// What is served at one moment.
struct Table {
  ResourceTable resources;
  std::string list = "[]";  ///< JSON
};

}  // namespace catalog

namespace {

using namespace catalog;

FileIdentity identity_at(const fs::path& file) {
  struct stat status{};
  return ::stat(file.c_str(), &status) == 0 ? identity_of(status) : FileIdentity();
}

/// Whether this process may list a folder and open what is in it; else errno says why not.
bool is_open(const fs::path& folder) {
  return ::faccessat(AT_FDCWD, folder.c_str(), R_OK | X_OK, AT_EACCESS) == 0;
}

/// Looks for packages below a folder. Folders that may not be entered are found, too: reading them
/// says so. False if there are too many folders.
bool look_into(const fs::path& folder, const std::string& prefix, int depth, std::size_t& budget,
               std::vector<PackageFolder>& found, bool& has_files) {
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    if (budget == 0) return false;
    --budget;
    std::error_code unknown;
    const fs::path& path = at->path();
    const std::string name = path.filename().string();
    if (name.starts_with('.')) continue;
    if (!at->is_directory(unknown)) {
      has_files = has_files || depth == 0;
      continue;
    }
    // Below these names the server and the page have something else.
    const bool is_reserved = name == "live" || name == "page";
    if (fs::exists(path / kManifestName, unknown) || unknown == std::errc::permission_denied) {
      found.push_back({path, prefix + name, true});
    } else if (depth + 1 < kMaxFolderDepth && !at->is_symlink(unknown) && !is_reserved &&
               !look_into(path, prefix + name + "/", depth + 1, budget, found, has_files)) {
      return false;
    }
  }
  if (error == std::errc::permission_denied && depth > 0)
    found.push_back({folder, prefix.substr(0, prefix.size() - 1), true});
  return true;
}

/// Reads a package. Files that it had `before` are not looked at again.
Result<std::shared_ptr<const Package>> read_package(const PackageFolder& from,
                                                    const Package* before) {
  const std::string given = from.folder.string(), &name = from.name;
  if (std::ranges::any_of(name, is_odd)) return tl::unexpected(unusable_name(from.folder));
  std::error_code error;
  const fs::path folder = fs::canonical(from.folder, error);
  if (error) return fail(ErrorCode::not_found, fmt::format("{}: {}", given, error.message()));
  auto package = std::make_shared<Package>();
  package->manifest = identity_at(folder / kManifestName);
  package->journal = identity_at(folder / kJournalName);
  if (package->manifest == FileIdentity()) {
    if (!is_open(folder)) {
      return fail(ErrorCode::io,
                  fmt::format("{}: {}", given, std::generic_category().message(errno)));
    }
    return fail(ErrorCode::not_found,
                fmt::format("{}: holds no {}, and no packages; make one with pointreel-server pack",
                            given, kManifestName));
  }
  const auto manifest_file = file_inside(folder, kManifestName);
  if (!manifest_file) return fail_at(given, manifest_file.error());
  const std::string manifest_place = (from.folder / kManifestName).string();
  auto text = read_text(*manifest_file, kMaxManifestBytes);
  if (!text) return fail_at(manifest_place, text.error());
  text = with_journal(folder, *std::move(text));
  if (!text) return tl::unexpected(text.error());
  const auto manifest = parse_manifest(*text);
  if (!manifest) return fail_at(manifest_place, manifest.error());

  std::unordered_map<std::string_view, std::shared_ptr<const Resource>> known;
  if (before != nullptr) {
    for (const auto& [path, resource] : before->entries) known.emplace(path, resource);
  }
  std::set<std::string_view> named;
  std::uint64_t bytes = text->size();
  const auto add = [&](std::string path, Resource resource) {
    package->entries.emplace_back(std::move(path),
                                  std::make_shared<const Resource>(std::move(resource)));
  };
  add(fmt::format("/{}/{}", name, kManifestName),
      text_resource(kJson, kRevalidate, *std::move(text)));
  for (const PackageFile* listed : manifest->files()) {
    if (!named.insert(listed->path).second || listed->path == kManifestName) {
      return fail(fmt::format("{}: the manifest names the file '{}' twice", given, listed->path));
    }
    bytes += listed->bytes;
    std::string path = fmt::format("/{}/{}", name, listed->path);
    const auto old = known.find(path);
    if (old != known.end() && old->second->size == listed->bytes &&
        old->second->checksum == listed->checksum) {
      package->entries.emplace_back(std::move(path), old->second);
      continue;
    }
    // Browsers play what is said to be sound, and nothing else.
    const bool sound = manifest->audio && listed->path == manifest->audio->path;
    auto resource =
        file_resource(folder, *listed, sound ? "audio/ogg" : "application/octet-stream");
    if (!resource) return fail_at(given, resource.error());
    add(std::move(path), *std::move(resource));
  }

  const std::string url = encode_path(name);
  const Resource redirect = redirect_resource(fmt::format("{}/{}", url, kManifestName));
  add("/" + name, redirect);
  add("/" + name + "/", redirect);
  package->listing = {{"name", name},
                      {"url", url},
                      {"manifest", redirect.text},
                      {"frames", shown_frames(*manifest).size()},
                      {"fps", manifest->fps},
                      {"duration_us", manifest->duration_us},
                      {"bytes", bytes},
                      {"codec", manifest->codec},
                      {"changed_us", package->manifest.modified_ns / 1000}};
  if (manifest->captured_us) package->listing["captured_us"] = *manifest->captured_us;
  return package;
}

std::shared_ptr<const Table> table_of(const std::vector<PackageFolder>& order,
                                      const Packages& packages) {
  auto table = std::make_shared<Table>();
  nlohmann::ordered_json listing = nlohmann::ordered_json::array();
  std::set<std::string_view> listed;
  for (const PackageFolder& folder : order) {
    const auto package = packages.find(folder.name);
    if (package == packages.end() || !listed.insert(folder.name).second) continue;
    listing.push_back(package->second->listing);
    for (const auto& [path, resource] : package->second->entries)
      table->resources.emplace(path, resource);
  }
  if (!listing.empty()) table->list = text_of(listing);
  // May be the redirect of a package of that name.
  table->resources.insert_or_assign(
      "/healthz", std::make_shared<const Resource>(
                      text_resource("text/plain; charset=utf-8", "no-store", "ok\n")));
  return table;
}

constexpr std::chrono::milliseconds kListPause{100};

}  // namespace

struct Catalog::State {
  // Used by refresh only.
  Packages packages;
  std::map<std::string, std::string> faults;  ///< by folder
  std::vector<std::string> order;

  std::shared_ptr<const LiveResources> live;
  mutable std::mutex mutex;  // guards what follows
  std::shared_ptr<const Table> table = table_of({}, {});
  std::shared_ptr<const Resource> list;
  std::chrono::steady_clock::time_point list_until;
};

Result<std::vector<PackageFolder>> packages_in(const std::vector<fs::path>& folders) {
  std::vector<PackageFolder> packages;
  std::size_t budget = kMaxFolders;
  for (const fs::path& folder : folders) {
    std::error_code error;
    std::vector<PackageFolder> inside;
    bool has_files = false;
    if (!fs::exists(folder / kManifestName, error)) {
      if (!look_into(folder, "", 0, budget, inside, has_files)) {
        return fail(ErrorCode::limit,
                    fmt::format("{}: holds more than {} files and folders outside of packages; "
                                "name a folder with fewer",
                                folder.string(), kMaxFolders));
      }
      std::ranges::sort(inside, [](const PackageFolder& a, const PackageFolder& b) {
        return natural_less(a.folder.native(), b.folder.native());
      });
      if (inside.empty() && !has_files && is_open(folder) && fs::is_directory(folder, error))
        continue;
    }
    if (inside.empty()) inside.push_back({folder, TRY(segment_name(folder))});
    packages.insert(packages.end(), inside.begin(), inside.end());
  }
  return packages;
}

Catalog::Catalog() : state_(std::make_shared<State>()) {}

void Catalog::add(std::shared_ptr<const LiveResources> live) { state_->live = std::move(live); }

Result<Catalog> Catalog::load(const std::vector<fs::path>& folders) {
  Catalog catalog;
  const std::vector<PackageFolder> found = TRY(packages_in(folders));
  for (const PackageFolder& folder : found) {
    if (catalog.state_->packages.contains(folder.name)) {
      return fail(ErrorCode::argument,
                  fmt::format("{}: another package is named '{}' too; rename one of the folders",
                              folder.folder.string(), folder.name));
    }
    auto package = read_package(folder, nullptr);
    if (!package && folder.found) continue;
    catalog.state_->packages.emplace(folder.name, TRY(std::move(package)));
    catalog.state_->order.push_back(folder.name);
  }
  catalog.state_->table = table_of(found, catalog.state_->packages);
  return catalog;
}

Catalog::News Catalog::refresh(const std::vector<fs::path>& folders) {
  State& state = *state_;
  News news;
  std::map<std::string, std::string> faults;
  const auto fault = [&](const std::string& place, const std::string& line) {
    const auto told = state.faults.find(place);
    if (told == state.faults.end() || told->second != line) news.faults.push_back(line);
    faults[place] = line;
  };
  const auto found = packages_in(folders);
  if (!found) {
    fault("", found.error().message);
    state.faults = std::move(faults);
    return news;
  }
  Packages packages;
  std::vector<std::string> order;
  bool changed = false;
  for (const PackageFolder& folder : *found) {
    const std::string place = folder.folder.string();
    if (packages.contains(folder.name)) {
      fault(place, fmt::format("{}: another package is named '{}' too; rename one of the folders",
                               place, folder.name));
      continue;
    }
    const auto old = state.packages.find(folder.name);
    const bool is_new = old == state.packages.end();
    if (!is_new && old->second->manifest == identity_at(folder.folder / kManifestName) &&
        old->second->journal == identity_at(folder.folder / kJournalName)) {
      packages.emplace(folder.name, old->second);
    } else {
      auto read = read_package(folder, is_new ? nullptr : old->second.get());
      if (!read) {
        fault(place, read.error().message);
        continue;
      }
      packages.emplace(folder.name, *std::move(read));
      changed = true;
      if (is_new) news.changes.push_back(place + ": is served now");
    }
    order.push_back(folder.name);
  }
  for (const auto& [name, package] : state.packages) {
    if (!packages.contains(name)) news.changes.push_back(name + ": is no longer served");
  }
  changed = changed || order != state.order;
  state.packages = std::move(packages);
  state.order = std::move(order);
  state.faults = std::move(faults);
  if (!changed) return news;
  auto table = table_of(*found, state.packages);
  const std::lock_guard lock(state.mutex);
  state.table.swap(table);
  state.list.reset();
  return news;
}

std::shared_ptr<const Resource> Catalog::list(
    const std::function<std::vector<StreamStatistics>()>& streams) const {
  State& state = *state_;
  const auto now = std::chrono::steady_clock::now();
  std::shared_ptr<const Table> table;
  {
    const std::lock_guard lock(state.mutex);
    if (state.list != nullptr && now < state.list_until) return state.list;
    state.list_until = now + kListPause;  // the others get the old one meanwhile
    table = state.table;
  }
  nlohmann::ordered_json live = nlohmann::ordered_json::array();
  for (const StreamStatistics& stream : streams ? streams() : std::vector<StreamStatistics>()) {
    const std::string url = "/live/" + stream.name;
    live.push_back({{"name", stream.name},
                    {"url", url},
                    {"manifest", fmt::format("{}/{}", url, kManifestName)},
                    {"publishing", stream.publishing},
                    {"viewers", stream.viewers}});
  }
  auto list = std::make_shared<const Resource>(text_resource(
      kJson, kRevalidate,
      fmt::format("{{\"packages\": {},\n\"streams\": {}}}\n", table->list, text_of(live))));
  const std::lock_guard lock(state.mutex);
  if (state.table == table) state.list = list;
  return list;
}

std::shared_ptr<const Resource> Catalog::find(std::string_view path) const {
  std::shared_ptr<const Table> table;
  {
    const std::lock_guard lock(state_->mutex);
    table = state_->table;
  }
  const auto found = table->resources.find(path);
  if (found != table->resources.end()) return found->second;
  return state_->live == nullptr ? nullptr : state_->live->find(path);
}

}  // namespace pointreel
