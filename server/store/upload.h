#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "codec/package/http_folder.h"
#include "common/http/http_options.h"
#include "pointreel/error.h"
#include "pointreel/package.h"

namespace pointreel {

/// What is uploaded, and where to.
struct UploadOptions {
  std::string to;       ///< s3://BUCKET/REEL
  HttpOptions http;     ///< how; `http.stop` interrupts
  bool force = false;   ///< replace another reel that is there
  bool follow = false;  ///< upload what a recording grows by, until it ends
};

/// How it reports its progress; every member may be empty. Called by any thread, one at a time.
struct UploadListener {
  std::function<void(std::size_t files)> begin;
  std::function<void()> file_done;
};

struct UploadSummary {
  std::uint64_t files = 0, bytes = 0;  ///< that were sent, manifests included
  std::uint64_t kept = 0;              ///< files that were there already
  bool growing = false;                ///< the package was still being recorded
};

/// A place of an object store for a package.
class Uploader {
 public:
  /// Asks the store what is there, so that wrong keys and addresses are found before a package is
  /// made. Errors: those of resolve_folder; `argument` if `to` is in no store; `io` if the store
  /// refuses.
  static Result<Uploader> open(UploadOptions options);

  /// Uploads a package: first the files that the manifest names, several at a time, and then the
  /// manifest, so that what is there can be played at any moment. A file that is there with the
  /// same size and checksum is not sent again, if the manifest there names it or an interrupted
  /// upload has left it. Files of the reel that was there before remain.
  ///
  /// Each file is compared with the checksum in its manifest before it is sent, and the store
  /// compares what arrives with its MD5.
  ///
  /// Caches may keep files for good, because they never change, and ask for the manifest each time.
  Result<UploadSummary> upload(const std::filesystem::path& package,
                               const UploadListener& listener = {});

 private:
  Result<void> may_replace(const Manifest& fresh) const;

  UploadOptions options_;
  HttpFolder folder_;
  std::string there_;  ///< the text of the manifest in the store; empty if there is none
};

}  // namespace pointreel
