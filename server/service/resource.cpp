#include "server/service/resource.h"

#include <utility>

#include "pointreel/package.h"
#include "server/service/entity_tag.h"

namespace pointreel {

Resource text_resource(std::string content_type, std::string cache_control, std::string text) {
  Resource resource;
  resource.content_type = std::move(content_type);
  resource.cache_control = std::move(cache_control);
  resource.etag =
      make_etag(checksum_of({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}));
  resource.size = text.size();
  resource.text = std::move(text);
  return resource;
}

Resource redirect_resource(std::string location) {
  Resource resource;
  resource.kind = Resource::Kind::kRedirect;
  resource.text = std::move(location);
  return resource;
}

}  // namespace pointreel
