#pragma once

#include "codec/files/byte_source.h"
#include "codec/files/read_notes.h"
#include "pointreel/cloud.h"
#include "pointreel/error.h"

namespace pointreel {

/// Reads a message sensor_msgs/msg/PointCloud2 of ROS 2 in CDR, of either byte order, as recordings
/// hold it. named_fields.h says what is read of its fields, which may have any order, type and
/// padding, and records.h how numbers become positions and colours. Points that were not measured
/// (NaN) remain in the cloud. `notes` receives the names of other
/// fields, such as those of several numbers. A count of 0 stands for 1, and a row_step of 0 for
/// rows that follow each other.
///
/// The error names the member of the message.
/// Sources: "common_interfaces", ROS 2 (sensor_msgs/msg/PointCloud2.msg); "Data Distribution
/// Service Interoperability Wire Protocol 2.5", Object Management Group, section 10.
///
/// Trust: the bytes may be hostile. Memory is bounded by a constant times their number, whatever
/// the message says.
Result<PointCloud> read_point_cloud2(const ByteSource& source, ReadNotes& notes);

}  // namespace pointreel
