#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace brim::test {

/// A DICOM file, element by element in the order of their tags (DICOM PS3.10 and PS3.5, explicit types).
class DicomWriter {
 public:
  explicit DicomWriter(bool big = false) : big_(big) {}

  void text(unsigned group, unsigned element, const char* type, std::string value) {
    if (value.size() % 2 != 0) value += std::string(type) == "UI" ? '\0' : ' ';
    put(group, element, type, value);
  }
  void number(unsigned group, unsigned element, unsigned value) { put(group, element, "US", two(value)); }
  /// Items, each the elements of a writer.
  void sequence(unsigned group, unsigned element, const std::vector<DicomWriter>& items) {
    std::string body;
    for (const DicomWriter& item : items)
      body += two(0xfffe) + two(0xe000) + four(static_cast<std::uint32_t>(item.body_.size())) + item.body_;
    put(group, element, "SQ", body);
  }
  void pixels(const std::vector<std::int16_t>& values) {
    std::string body;
    for (const std::int16_t v : values) body += two(static_cast<std::uint16_t>(v));
    put(0x7fe0, 0x0010, "OW", body);
  }
  std::string file() const {
    DicomWriter meta;
    meta.text(0x0002, 0x0002, "UI", "1.2.840.10008.5.1.4.1.1.2");
    meta.text(0x0002, 0x0003, "UI", "1.2.3.4");
    meta.text(0x0002, 0x0010, "UI", big_ ? "1.2.840.10008.1.2.2" : "1.2.840.10008.1.2.1");
    DicomWriter length;
    length.put(0x0002, 0x0000, "UL", length.four(static_cast<std::uint32_t>(meta.body_.size())));
    return std::string(128, '\0') + "DICM" + length.body_ + meta.body_ + body_;
  }

 private:
  std::string two(unsigned x) const {
    const char low = static_cast<char>(x & 255u), high = static_cast<char>(x >> 8 & 255u);
    return big_ ? std::string{high, low} : std::string{low, high};
  }
  std::string four(std::uint32_t x) const {
    return big_ ? two(x >> 16) + two(x & 65535u) : two(x & 65535u) + two(x >> 16);
  }
  void put(unsigned group, unsigned element, const std::string& type, const std::string& value) {
    body_ += two(group) + two(element) + type;
    const bool wide = type == "OW" || type == "SQ";
    body_ += wide ? std::string(2, '\0') + four(static_cast<std::uint32_t>(value.size()))
                  : two(static_cast<unsigned>(value.size()));
    body_ += value;
  }

  bool big_;
  std::string body_;
};

inline std::string decimals(const std::vector<double>& values) {
  std::string text;
  for (const double v : values) {
    if (!text.empty()) text += '\\';
    text += fmt::format("{:.10g}", v);
  }
  return text;
}

/// One slice of a CT as scanners write it.
struct DicomSlice {
  std::string series = "1.2.3";
  std::vector<double> position{0, 0, 0};
  std::vector<double> orientation{1, 0, 0, 0, 1, 0};
  std::vector<double> spacing{0.5, 0.25};  ///< [mm] between rows, between columns
  double thickness = 5.0, slope = 1.0, intercept = 0.0;
  unsigned width = 4, height = 3, stored = 16, is_signed = 1;
  std::vector<std::int16_t> pixels;
  bool big = false, placed = true;

  std::string file() const {
    DicomWriter w(big);
    w.text(0x0008, 0x0016, "UI", "1.2.840.10008.5.1.4.1.1.2");
    w.text(0x0008, 0x0018, "UI", "1.2.3.4");
    w.text(0x0008, 0x0060, "CS", "CT");
    w.text(0x0008, 0x103e, "LO", "made by hand");
    w.text(0x0018, 0x0050, "DS", decimals({thickness}));
    w.text(0x0020, 0x000e, "UI", series);
    w.text(0x0020, 0x0011, "IS", "7");
    if (placed) w.text(0x0020, 0x0032, "DS", decimals(position));
    w.text(0x0020, 0x0037, "DS", decimals(orientation));
    image(w);
    w.pixels(pixels);
    return w.file();
  }
  /// Elements of group 28.
  void image(DicomWriter& w, bool own_places = true) const {
    w.number(0x0028, 0x0002, 1);
    w.text(0x0028, 0x0004, "CS", "MONOCHROME2");
    if (!own_places) w.text(0x0028, 0x0008, "IS", std::to_string(pixels.size() / (width * height)));
    w.number(0x0028, 0x0010, height);
    w.number(0x0028, 0x0011, width);
    if (own_places) w.text(0x0028, 0x0030, "DS", decimals(spacing));
    w.number(0x0028, 0x0100, 16);
    w.number(0x0028, 0x0101, stored);
    w.number(0x0028, 0x0102, stored - 1);
    w.number(0x0028, 0x0103, is_signed);
    if (!own_places) return;
    w.text(0x0028, 0x1052, "DS", decimals({intercept}));
    w.text(0x0028, 0x1053, "DS", decimals({slope}));
  }
};

}  // namespace brim::test
