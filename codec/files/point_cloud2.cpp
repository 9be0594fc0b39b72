#include "codec/files/point_cloud2.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>

#include "codec/files/named_fields.h"
#include "codec/files/ply_header.h"
#include "common/base/concat.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

/// Far more than any real message has.
constexpr std::uint32_t kMaxMessageFields = 1024;

/// Reads CDR: numbers are aligned to their size, counted from behind the first four bytes. Past the
/// end, every value is zero and `ok()` stays false.
class CdrReader {
 public:
  explicit CdrReader(ByteView bytes) : bytes_(bytes) {
    if (bytes.size() < kHead || bytes[0] != 0 || bytes[1] > 1) {
      ok_ = false;
    } else {
      swapped_ = bytes[1] == 0;
    }
  }

  template <class T>
  T get() {
    const std::size_t at = kHead + (at_ + sizeof(T) - 1) / sizeof(T) * sizeof(T);
    if (!ok_ || at > bytes_.size() || bytes_.size() - at < sizeof(T)) {
      ok_ = false;
      return T{};
    }
    at_ = at + sizeof(T) - kHead;
    const std::uint8_t* const from = bytes_.data() + at;
    return swapped_ ? load_number<T, true>(from) : load_number<T>(from);
  }

  ByteView get_bytes() {
    const auto size = get<std::uint32_t>();
    if (!ok_ || size > bytes_.size() - kHead - at_) {
      ok_ = false;
      return {};
    }
    const ByteView part = bytes_.subspan(kHead + at_, size);
    at_ += size;
    return part;
  }

  /// A string, which ends in a zero.
  std::string_view get_string() {
    const ByteView part = get_bytes();
    const std::string_view text(reinterpret_cast<const char*>(part.data()), part.size());
    return text.ends_with('\0') ? text.substr(0, text.size() - 1) : text;
  }

  bool ok() const { return ok_; }

 private:
  static constexpr std::size_t kHead = 4;
  ByteView bytes_;
  std::size_t at_ = 0;  ///< behind the head
  bool swapped_ = false, ok_ = true;
};

std::optional<NumberType> type_of(std::uint8_t code) {
  constexpr std::array<NumberType, 8> kTypes{
      NumberType::int8,  NumberType::uint8,  NumberType::int16,   NumberType::uint16,
      NumberType::int32, NumberType::uint32, NumberType::float32, NumberType::float64};
  if (code < 1 || code > kTypes.size()) return std::nullopt;
  return kTypes[code - 1];
}

struct Message {
  std::uint32_t height = 0, width = 0, point_step = 0, row_step = 0;
  std::vector<NamedField> fields;
  std::vector<std::string> others;  ///< names of fields with more numbers than one
  bool swapped = false;
  ByteView data;
};

Result<Message> parse(ByteView bytes) {
  CdrReader cdr(bytes);
  if (!cdr.ok()) return fail("is not a CDR message");
  Message message;
  cdr.get<std::int32_t>();  // when it was measured
  cdr.get<std::uint32_t>();
  cdr.get_string();  // frame_id
  message.height = cdr.get<std::uint32_t>();
  message.width = cdr.get<std::uint32_t>();
  const auto fields = cdr.get<std::uint32_t>();
  if (fields > kMaxMessageFields)
    return fail(ErrorCode::limit,
                concat("fields: has ", fields, ", more than ", kMaxMessageFields));
  for (std::uint32_t i = 0; i < fields && cdr.ok(); ++i) {
    const std::string_view name = cdr.get_string();
    const auto offset = cdr.get<std::uint32_t>();
    const auto type = type_of(cdr.get<std::uint8_t>());
    const auto count = cdr.get<std::uint32_t>();
    if (!cdr.ok()) break;
    if (!type) return fail(concat("fields: the type of ", printable(name), " does not exist"));
    // PCL writes 0 for 1.
    if (count <= 1) {
      message.fields.push_back({std::string(name), {offset, 0, *type}});
    } else {
      message.others.push_back(printable_name(name));
    }
  }
  message.swapped = cdr.get<std::uint8_t>() != 0;
  message.point_step = cdr.get<std::uint32_t>();
  message.row_step = cdr.get<std::uint32_t>();
  message.data = cdr.get_bytes();
  if (!cdr.ok())
    return fail(concat("byte ", bytes.size(), ": the message ends within its members"));
  return message;
}

Result<void> check(Message& message) {
  const std::uint64_t row = std::uint64_t{message.width} * message.point_step;
  if (message.point_step == 0) return fail("point_step: is 0");
  for (const NamedField& named : message.fields) {
    if (named.field.offset + size_of(named.field.type) > message.point_step) {
      return fail(concat("fields: ", printable(named.name), " ends after point_step, which is ",
                         message.point_step));
    }
  }
  // Some writers leave it at 0: then rows follow each other.
  if (message.row_step == 0 && row <= std::numeric_limits<std::uint32_t>::max())
    message.row_step = static_cast<std::uint32_t>(row);
  if (message.height > 1 && message.row_step < row)
    return fail(concat("row_step: is ", message.row_step, ", but a row takes ", row, " bytes"));
  const std::uint64_t all = (message.height - 1) * std::uint64_t{message.row_step} + row;
  if (message.data.size() < all)
    return fail(concat("data: has ", message.data.size(), " bytes, but its points take ", all));
  return {};
}

}  // namespace

Result<PointCloud> read_point_cloud2(const ByteSource& source, ReadNotes& notes) {
  Bytes room;
  Message message = TRY(parse(TRY(source.all(room))));
  if (message.width == 0 || message.height == 0) return PointCloud{};
  TRY(check(message));
  for (NamedField& named : message.fields) named.field.stride = message.point_step;
  RecordLayout layout = TRY(layout_of(message.fields, notes.unread));
  layout.swapped = message.swapped;
  notes.unread.insert(notes.unread.end(), message.others.begin(), message.others.end());
  RecordCollector collector(layout, std::size_t{message.width} * message.height);
  for (std::uint32_t row = 0; row < message.height; ++row) {
    collector.add(message.data.data() + std::size_t{row} * message.row_step, 0, message.width);
  }
  return collector.finish(notes);
}

}  // namespace pointreel
