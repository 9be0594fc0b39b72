#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>

#include "common/http/aws_access.h"
#include "common/http/http_options.h"
#include "pointreel/error.h"

namespace pointreel {

/// The content of an object: a file, or a text in memory.
class ObjectContent {
 public:
  /// `text` outlives this object.
  explicit ObjectContent(std::string_view text);
  /// Errors (`io`) begin with the path.
  static Result<ObjectContent> open(const std::filesystem::path& file);
  ObjectContent(ObjectContent&& other) noexcept;
  ObjectContent& operator=(ObjectContent&&) = delete;
  ~ObjectContent();

  std::uint64_t bytes() const { return bytes_; }
  /// In hexadecimal digits. An error if it cannot be read.
  Result<std::string> md5() const;
  /// Up to `size` bytes from `offset` on; none at the end, or if they cannot be read.
  std::size_t read(std::uint64_t offset, char* to, std::size_t size) const;

 private:
  ObjectContent() = default;
  int file_ = -1;
  std::string_view text_;
  std::uint64_t bytes_ = 0;
};

/// What is stored with an object, and told to those who fetch it.
struct ObjectHeaders {
  std::string content_type, cache_control;
  std::uint64_t checksum = 0;  ///< checksum_of its content
};

/// What a store says about an object.
struct StoredObject {
  std::uint64_t bytes = 0;
  std::optional<std::uint64_t> checksum;  ///< none if it was not stored with ObjectHeaders
  /// Of what the store has, as it says itself; none where its tags are something else.
  std::optional<std::string> md5;
};

/// Reads and writes objects of a store, one after another over a connection that is kept: for one
/// thread, in which SIGPIPE is blocked from then on. Failures that may pass are tried again,
/// HttpOptions::open_attempts times in all. Errors begin with the address; `cancelled` if
/// HttpOptions::stop was asked to stop.
///
/// Trust: the store may be hostile. Answers are bounded, redirects are not followed, and keys go
/// nowhere but to the address.
class ObjectStore {
 public:
  ObjectStore(const HttpOptions& options, AwsAccess access);
  ~ObjectStore();
  ObjectStore(const ObjectStore&) = delete;
  ObjectStore& operator=(const ObjectStore&) = delete;

  /// What is there; none if there is nothing, or if the keys do not give the right to look.
  Result<std::optional<StoredObject>> look(const std::string& url);

  /// A short object. None: as above. An error if it has more than `max_bytes`.
  Result<std::optional<std::string>> get(const std::string& url, std::uint64_t max_bytes);

  /// Replaces what is there. The store gets the MD5 of the content, and refuses what arrives
  /// damaged; what it says to have stored is compared as well.
  Result<void> put(const std::string& url, const ObjectContent& content,
                   const ObjectHeaders& headers);

 private:
  class Request;
  template <class Attempt>
  Result<void> perform(const std::string& url, const Attempt& attempt);

  const HttpOptions& options_;
  const AwsAccess access_;
  void* const handle_;
};

}  // namespace pointreel
