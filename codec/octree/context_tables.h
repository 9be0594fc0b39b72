#pragma once

#include <cstdint>
#include <memory>

#include "codec/octree/context_model.h"
#include "pointreel/bytes.h"
#include "pointreel/codec.h"
#include "pointreel/error.h"

/// Tables as they are stored: the trained ones that are part of the format, and a package's own. A
/// frame names its tables by number, and a number stands for the same tables for good: better ones
/// get the next number. tables/README.md tells how they were trained.
namespace pointreel {

/// What an encoder uses. Known numbers are 1 to this.
inline constexpr std::uint8_t kNewestTables = 1;
/// Stands for tables that come with the frames; their checksum follows it.
inline constexpr std::uint8_t kGivenTables = 255;

/// A package's own tables as a file; read_table_file is the way back. FORMAT.md, "Tables of a
/// package". `tables`: as write_tables makes them, based on the newest numbered ones.
Result<Bytes> write_table_file(ByteView tables);
/// Unpacked when first asked for, and shared from then on; safe from any thread.
Result<std::shared_ptr<const ContextTables>> tables_of_number(std::uint8_t number);

}  // namespace pointreel
