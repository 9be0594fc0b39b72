#include "server/serve/catalog.h"

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <sys/stat.h>
#include <unistd.h>

#include "common/base/natural_order.h"
#include "common/base/try.h"
#include "common/base/words.h"
#include "common/stream/manifest.h"
#include "common/stream/running_checksum.h"
#include "pointreel/package.h"
#include "server/serve/entity_tag.h"
#include "server/serve/request_target.h"

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

/// The name under which the package in a folder is served.
Result<std::string> package_name(const fs::path& folder) {
  std::error_code error;
  const fs::path absolute = fs::absolute(folder, error);
  if (error) return fail(ErrorCode::io, fmt::format("{}: {}", folder.string(), error.message()));
  fs::path normal = absolute.lexically_normal();
  if (!normal.has_filename()) normal = normal.parent_path();  // "reel/"
  std::string name = normal.filename().string();
  const auto is_odd = [](char c) {
    return c == '\\' || c == 0x7f || static_cast<unsigned char>(c) < 0x20;
  };
  if (name.empty() || name == "." || name == ".." || std::ranges::any_of(name, is_odd)) {
    return fail(
        ErrorCode::argument,
        fmt::format("{}: the folder's name cannot be used in a URL; rename it", folder.string()));
  }
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

Result<std::string> read_manifest_text(const fs::path& file) {
  std::error_code error;
  const std::uint64_t size = fs::file_size(file, error);
  if (error) return fail(ErrorCode::io, error.message());
  if (size > kMaxManifestBytes) {
    return fail(ErrorCode::limit,
                fmt::format("has {} bytes; at most {} are allowed", size, kMaxManifestBytes));
  }
  std::string text(size, '\0');
  std::ifstream in(file, std::ios::binary);
  in.read(text.data(), static_cast<std::streamsize>(size));
  if (!in) return fail(ErrorCode::io, "cannot be read; check its permissions");
  return text;
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

std::vector<fs::path> packages_in(const std::vector<fs::path>& folders) {
  std::vector<fs::path> packages;
  for (const fs::path& folder : folders) {
    std::error_code error;
    std::vector<fs::path> inside;
    if (!fs::exists(folder / kManifestName, error)) {
      for (fs::directory_iterator at(folder, error), end; !error && at != end;
           at.increment(error)) {
        std::error_code unknown;
        const fs::path& path = at->path();
        if (!path.filename().native().starts_with('.') && fs::exists(path / kManifestName, unknown))
          inside.push_back(path);
      }
    }
    if (inside.empty()) inside.push_back(folder);
    std::ranges::sort(inside, [](const fs::path& a, const fs::path& b) {
      return natural_less(a.native(), b.native());
    });
    packages.insert(packages.end(), inside.begin(), inside.end());
  }
  return packages;
}

Result<Catalog> Catalog::load(const std::vector<fs::path>& folders) {
  Catalog catalog;
  auto& resources = catalog.resources_;
  const auto add = [&](const std::string& path, Resource resource) {
    return resources.emplace(path, std::make_shared<const Resource>(std::move(resource))).second;
  };
  nlohmann::ordered_json listing = nlohmann::ordered_json::array();

  for (const fs::path& given : folders) {
    const std::string name = TRY(package_name(given));
    std::error_code error;
    const fs::path folder = fs::canonical(given, error);
    if (error) {
      return fail(ErrorCode::not_found, fmt::format("{}: {}", given.string(), error.message()));
    }
    if (!fs::exists(folder / kManifestName, error)) {
      return fail(
          ErrorCode::not_found,
          fmt::format("{}: holds no {}, and no packages; make one with pointreel-server pack",
                      given.string(), kManifestName));
    }
    const std::string manifest_path = fmt::format("/{}/{}", name, kManifestName);
    if (resources.contains(manifest_path)) {
      return fail(ErrorCode::argument,
                  fmt::format("{}: another package is named '{}' too; rename one of the folders",
                              given.string(), name));
    }
    const auto manifest_file = file_inside(folder, kManifestName);
    if (!manifest_file) return fail_at(given.string(), manifest_file.error());
    auto text = read_manifest_text(*manifest_file);
    if (!text) return fail_at((given / kManifestName).string(), text.error());
    text = with_journal(folder, *std::move(text));
    if (!text) return tl::unexpected(text.error());
    const auto manifest = parse_manifest(*text);
    if (!manifest) return fail_at((given / kManifestName).string(), manifest.error());

    std::uint64_t bytes = text->size();
    add(manifest_path, text_resource(kJson, kRevalidate, *std::move(text)));
    for (const PackageFile* listed : manifest->files()) {
      // Browsers play what is said to be sound, and nothing else.
      const bool sound = manifest->audio && listed->path == manifest->audio->path;
      auto resource =
          file_resource(folder, *listed, sound ? "audio/ogg" : "application/octet-stream");
      if (!resource) return fail_at(given.string(), resource.error());
      bytes += listed->bytes;
      if (!add(fmt::format("/{}/{}", name, listed->path), *std::move(resource))) {
        return fail(fmt::format("{}: the manifest names the file '{}' twice", given.string(),
                                listed->path));
      }
    }

    const std::string url = "/" + encode_segment(name);
    const Resource redirect = redirect_resource(fmt::format("{}/{}", url, kManifestName));
    add("/" + name, redirect);
    add("/" + name + "/", redirect);
    listing.push_back({{"name", name},
                       {"url", url},
                       {"manifest", redirect.text},
                       {"frames", manifest->frame_count()},
                       {"fps", manifest->fps},
                       {"duration_us", manifest->duration_us},
                       {"bytes", bytes},
                       {"codec", manifest->codec}});
  }

  catalog.packages_ = text_of(listing);
  resources.erase("/healthz");  // may be the redirect of a package of that name
  add("/healthz", text_resource("text/plain; charset=utf-8", "no-store", "ok\n"));
  return catalog;
}

std::shared_ptr<const Resource> Catalog::list(const std::vector<StreamStatistics>& streams) const {
  nlohmann::ordered_json live = nlohmann::ordered_json::array();
  for (const StreamStatistics& stream : streams) {
    const std::string url = "/live/" + stream.name;
    live.push_back({{"name", stream.name},
                    {"url", url},
                    {"manifest", fmt::format("{}/{}", url, kManifestName)},
                    {"publishing", stream.publishing},
                    {"viewers", stream.viewers}});
  }
  return std::make_shared<const Resource>(text_resource(
      kJson, kRevalidate,
      fmt::format("{{\"packages\": {},\n\"streams\": {}}}\n", packages_, text_of(live))));
}

std::shared_ptr<const Resource> Catalog::find(std::string_view path) const {
  const auto found = resources_.find(path);
  if (found != resources_.end()) return found->second;
  return live_ == nullptr ? nullptr : live_->find(path);
}

}  // namespace pointreel
