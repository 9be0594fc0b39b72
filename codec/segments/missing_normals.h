#pragma once

#include <span>

#include "codec/files/cloud_file.h"
#include "codec/segments/pack_options.h"

namespace pointreel {

/// Whether frames are encoded with the normals that they have.
bool encodes_normals(const PackOptions& options);

/// Decides MissingNormals::estimated_if_it_pays by the first frame of a sequence. It pays if
/// players would take longer to derive the normals of its points than to decode them, and if it has
/// colours: with these, normals need only be rough, and so they take few bits. Estimated normals of
/// frames with colours are rough unless a quality was asked for.
void choose_normals(std::span<const CloudFrame> frames, PackOptions& options);
/// The same where `first` is the first frame.
void choose_normals(const PointCloud& first, PackOptions& options);

}  // namespace pointreel
