#include "server/service/page.h"

#include <array>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "server/service/negotiation.h"

namespace pointreel {
namespace {

constexpr std::string_view kStart = "index.html";
constexpr std::string_view kFolder = "/page/";

/// What the page may do. It is not needed for anything else, so that a fault in it, or a hostile
/// name in a manifest, cannot reach anything but this server.
constexpr std::string_view kPolicy =
    "Content-Security-Policy: default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; "
    "worker-src 'self'; style-src 'self'; img-src 'self' blob: data:; font-src 'self'; "
    "connect-src 'self'; media-src 'self' blob:; base-uri 'none'; form-action 'none'; "
    "frame-ancestors {}\r\n"
    "Referrer-Policy: no-referrer\r\n";

std::string_view type_of(std::string_view name) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 7> kTypes = {{
      {".html", "text/html; charset=utf-8"},
      {".js", "text/javascript; charset=utf-8"},
      {".css", "text/css; charset=utf-8"},
      {".wasm", "application/wasm"},
      {".svg", "image/svg+xml"},
      {".png", "image/png"},
      {".json", "application/json"},
  }};
  for (const auto& [ending, type] : kTypes) {
    if (name.ends_with(ending)) return type;
  }
  return "application/octet-stream";
}

}  // namespace

std::shared_ptr<const Page::Forms> Page::forms_of(const PageFile& file,
                                                  std::string_view frame_ancestors) {
  const bool start = file.name == kStart;
  const auto form = [&](std::string_view content, std::string_view coding) {
    // The start depends on what a browser asks for, too: programs get JSON at the same address.
    std::string fields =
        start ? fmt::format(kPolicy, frame_ancestors) + "Vary: Accept, Accept-Encoding\r\n"
              : "Vary: Accept-Encoding\r\n";
    if (!coding.empty()) fields += fmt::format("Content-Encoding: {}\r\n", coding);
    Resource resource = text_resource(std::string(type_of(file.name)),
                                      start ? kRevalidate : kImmutable, std::string(content));
    resource.fields = std::move(fields);
    return std::make_shared<const Resource>(std::move(resource));
  };
  Forms forms;
  forms.plain = form(file.plain, "");
  if (!file.brotli.empty()) forms.brotli = form(file.brotli, "br");
  if (!file.gzip.empty()) forms.gzip = form(file.gzip, "gzip");
  return std::make_shared<const Forms>(std::move(forms));
}

Page::Page(std::span<const PageFile> files, std::string_view frame_ancestors) {
  for (const PageFile& file : files) {
    if (file.name == kStart) {
      start_ = forms_of(file, frame_ancestors);
    } else {
      files_.emplace(file.name, forms_of(file, frame_ancestors));
    }
  }
}

const std::shared_ptr<const Resource>& Page::best(const Forms& forms,
                                                  std::string_view accept_encoding) {
  if (forms.brotli && names_acceptable(accept_encoding, "br")) return forms.brotli;
  if (forms.gzip && names_acceptable(accept_encoding, "gzip")) return forms.gzip;
  return forms.plain;
}

std::shared_ptr<const Resource> Page::start(std::string_view accept_encoding) const {
  return empty() ? nullptr : best(*start_, accept_encoding);
}

std::shared_ptr<const Resource> Page::find(std::string_view path,
                                           std::string_view accept_encoding) const {
  const auto at = path.rfind(kFolder);
  if (at == std::string_view::npos) return nullptr;
  const auto found = files_.find(path.substr(at + kFolder.size()));
  return found == files_.end() ? nullptr : best(*found->second, accept_encoding);
}

}  // namespace pointreel
