#include "client/source/whole_files.h"

#include <algorithm>

#include <fmt/format.h>

#include "codec/package/http_folder.h"
#include "common/base/try.h"
#include "common/net/url.h"

namespace pointreel {

Result<std::vector<Bytes>> WholeFiles::get_ranges(std::span<const HttpClient::Range> ranges,
                                                  const std::stop_token& stop, bool fresh) {
  if (!no_ranges_) {
    auto parts = client_.get_ranges(ranges, stop, fresh);
    if (parts || parts.error().code != ErrorCode::unsupported) return parts;
    if (!no_ranges_.exchange(true) && say_)
      say_("warning: " + parts.error().message + ", and is asked for whole files from now on");
  }
  std::vector<Bytes> parts;
  for (const HttpClient::Range& range : ranges)
    parts.push_back(TRY(part_of_file(range, stop, fresh)));
  return parts;
}

Result<Bytes> WholeFiles::part_of_file(const HttpClient::Range& range, const std::stop_token& stop,
                                       bool fresh) {
  if (range.total > kMostBytes)
    return fail(ErrorCode::limit,
                fmt::format("{}: the server sends whole files instead of ranges, and this one has "
                            "more than {} MiB; use a server that supports Range requests",
                            without_secrets(range.url), kMostBytes >> 20));
  const std::shared_ptr<File> file = file_of(range);
  const std::lock_guard lock(file->mutex);
  if (file->bytes.empty() || fresh) {
    const HttpClient::Range all{range.url, 0, range.total, range.total};
    file->bytes = std::move(TRY(client_.get_ranges({&all, 1}, stop, fresh)).front());
  }
  const auto begin = file->bytes.begin() + static_cast<std::ptrdiff_t>(range.offset);
  return Bytes(begin, begin + static_cast<std::ptrdiff_t>(range.size));
}

std::shared_ptr<WholeFiles::File> WholeFiles::file_of(const HttpClient::Range& range) {
  const std::lock_guard lock(mutex_);
  const auto kept = std::ranges::find(
      files_, range.url, [](const auto& file) -> const std::string& { return file->url; });
  if (kept != files_.end())
    files_.splice(files_.begin(), files_, kept);
  else
    files_.push_front(std::make_shared<File>(range.url, range.total));
  std::uint64_t bytes = 0;
  std::erase_if(files_, [&](const auto& file) { return (bytes += file->size) > kMostBytes; });
  return files_.front();
}

}  // namespace pointreel
