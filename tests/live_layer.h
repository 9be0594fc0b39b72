#pragma once

#include "codec/live/live.h"

namespace pointreel {

/// The whole message of a layer: its header and its bytes.
inline Bytes write_live_layer(const LiveLayer& layer) {
  Bytes message = write_live_header(layer);
  message.insert(message.end(), layer.bytes.begin(), layer.bytes.end());
  return message;
}

}  // namespace pointreel
