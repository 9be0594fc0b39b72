#pragma once

#include <cstdint>
#include <memory>

#include "codec/octree/context_model.h"
#include "pointreel/bytes.h"
#include "pointreel/codec.h"
#include "pointreel/error.h"

/// Stored context tables: those that are part of the format, and those of a package. A frame names
/// tables of the format by number. A number always stands for the same tables; better ones will get
/// the next number. tables/README.md describes how they were trained.
namespace pointreel {

/// The tables that encoders use by default. Numbers from 1 up to this are known.
inline constexpr std::uint8_t kNewestTables = 1;
/// The number that stands for a package's own tables. Their checksum follows it.
inline constexpr std::uint8_t kGivenTables = 255;

/// Makes the file of a package's own tables, which read_table_file reads. FORMAT.md, "Tables of a
/// package". `tables`: the result of write_tables, based on the tables of number kNewestTables.
Result<Bytes> write_table_file(ByteView tables);
/// The tables of the format with that number; `unsupported` if there are none. They are unpacked
/// once and then shared. Safe to call from any thread.
Result<std::shared_ptr<const ContextTables>> tables_of_number(std::uint8_t number);

}  // namespace pointreel
