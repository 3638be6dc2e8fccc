#include "volume_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>

#include "brim/core/error.h"

namespace brim::cli {

namespace {

constexpr std::size_t kBars = 24, kBarWidth = 50, kPerBar = 256 / kBars + 1;

void put32(std::string& out, std::uint32_t x) {
  for (int shift = 24; shift >= 0; shift -= 8) out += static_cast<char>(x >> shift & 255u);
}

std::uint32_t crc32(const std::string& data) {
  std::uint32_t crc = ~0u;
  for (const char c : data) {
    crc ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1u ? 0xedb88320u : 0u);
  }
  return ~crc;
}

void put_chunk(std::string& out, const std::string& type, const std::string& data) {
  put32(out, static_cast<std::uint32_t>(data.size()));
  out += type + data;
  put32(out, crc32(type + data));
}

/// A greyscale PNG whose rows are stored, not packed: no library is needed. @param grey  shape (height, width)
std::string png(const std::vector<std::uint8_t>& grey, std::size_t width, std::size_t height) {
  std::string head;
  put32(head, static_cast<std::uint32_t>(width));
  put32(head, static_cast<std::uint32_t>(height));
  head += std::string("\x08\x00\x00\x00\x00", 5);
  std::string raw;
  for (std::size_t y = 0; y < height; ++y) {
    raw += '\0';
    for (std::size_t x = 0; x < width; ++x) raw += static_cast<char>(grey[y * width + x]);
  }
  std::string packed = "\x78\x01";
  std::uint32_t a = 1, b = 0;
  for (const char c : raw) a = (a + static_cast<unsigned char>(c)) % 65521u, b = (b + a) % 65521u;
  for (std::size_t at = 0; at < raw.size(); at += 65535) {
    const std::size_t n = std::min<std::size_t>(65535, raw.size() - at);
    packed += at + n == raw.size() ? '\1' : '\0';
    for (const std::size_t x : {n, n ^ 0xffffu})
      packed += {static_cast<char>(x & 255u), static_cast<char>(x >> 8 & 255u)};
    packed += raw.substr(at, n);
  }
  put32(packed, b << 16 | a);
  std::string out = "\x89PNG\r\n\x1a\n";
  put_chunk(out, "IHDR", head);
  put_chunk(out, "IDAT", packed);
  put_chunk(out, "IEND", "");
  return out;
}

}  // namespace

VolumeHistogram::VolumeHistogram(const std::vector<float>& values) : count_(kBins, 0.0) {
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  lo_ = *least, hi_ = *most;
  const double scale = hi_ > lo_ ? kBins / (hi_ - lo_) : 0.0;
  for (const float v : values) count_[std::min(kBins - 1, static_cast<std::size_t>((v - lo_) * scale))] += 1.0;
}

std::pair<double, double> VolumeHistogram::thresholds() const {
  // Sums below each bin; the variance between classes is Σ (Σ v)² / Σ 1 less what does not change.
  std::vector<double> n(kBins + 1, 0.0), sum(kBins + 1, 0.0);
  for (std::size_t i = 0; i < kBins; ++i) {
    n[i + 1] = n[i] + count_[i];
    sum[i + 1] = sum[i] + count_[i] * (static_cast<double>(i) + 0.5);
  }
  const auto part = [&](std::size_t from, std::size_t to) {
    const double m = n[to] - n[from], s = sum[to] - sum[from];
    return m > 0.0 ? s * s / m : 0.0;
  };
  double best = -1.0;
  std::pair<std::size_t, std::size_t> cut{0, 0};
  for (std::size_t i = 1; i < kBins - 1; ++i)
    for (std::size_t j = i + 1; j < kBins; ++j) {
      const double between = part(0, i) + part(i, j) + part(j, kBins);
      if (between > best) best = between, cut = {i, j};
    }
  // Where nothing lies between two classes any threshold there is as good: the middle.
  const auto middle = [&](std::size_t i) {
    std::size_t end = i;
    while (end < kBins && count_[end] == 0.0) ++end;
    return 0.5 * (at(i) + at(end));
  };
  return {middle(cut.first), middle(cut.second)};
}

std::string VolumeHistogram::text() const {
  std::string out = fmt::format("  intensities {:.6g} to {:.6g}\n", lo_, hi_);
  if (!(hi_ > lo_)) return out;
  double all = 0.0, most = 1.0;
  std::vector<double> bars;
  for (std::size_t i = 0; i < kBins; i += kPerBar) {
    bars.push_back(0.0);
    for (std::size_t k = i; k < std::min(kBins, i + kPerBar); ++k) bars.back() += count_[k];
    all += bars.back();
    most = std::max(most, bars.back());
  }
  for (std::size_t b = 0; b < bars.size(); ++b) {
    const double share = bars[b] > 0.0 ? std::log1p(bars[b]) / std::log1p(most) : 0.0;
    const auto length = static_cast<std::size_t>(std::lround(share * kBarWidth));
    out += fmt::format("  {:>10.5g} {:<{}} {:.2g} %\n", at(b * kPerBar), std::string(length, '#'), kBarWidth,
                       100.0 * bars[b] / all);
  }
  out += "  (bars are logarithmic)\n";
  const auto [t1, t2] = thresholds();
  const double margin = 0.1 * std::min(t2 - t1, std::min(t1 - lo_, hi_ - t2));
  const char* const what[] = {"all but the darkest of three classes", "the brightest of three classes"};
  for (int i = 0; i < 2; ++i) {
    const double t = i == 0 ? t1 : t2;
    double above = 0.0;
    for (std::size_t b = 0; b < kBins; ++b)
      if (at(b) >= t) above += count_[b];
    out += fmt::format("  window [{:.5g}, {:.5g}] takes {}: {:.2g} %\n", t - margin, t + margin, what[i],
                       100.0 * above / all);
  }
  // Hounsfield's scale: air at -1000, water at 0.
  if (lo_ <= -900 && lo_ >= -4000 && hi_ >= 400)
    out += "  if these are Hounsfield units: bone [250, 450], the body without air [-400, -200]\n";
  return out;
}

void write_contact_sheet(const VoxelImage& image, const std::string& path) {
  constexpr int kColumns = 6, kRows = 4, kSide = 160, kGap = 2;
  const auto [least, most] = std::minmax_element(image.values.begin(), image.values.end());
  const double lo = *least, range = *most > *least ? *most - *least : 1.0;
  const Vec3i n = image.size;
  const int slices = std::min(kColumns * kRows, n.z()), rows = (slices + kColumns - 1) / kColumns;
  // One scale for both axes, in metres, so that what is round looks round.
  const double dx = image.axes.col(0).norm(), dy = image.axes.col(1).norm(),
               wide = std::max(n.x() * dx, n.y() * dy) / kSide;
  const int w = std::max(1, static_cast<int>(n.x() * dx / wide)), h = std::max(1, static_cast<int>(n.y() * dy / wide));
  const int width = kColumns * (w + kGap) - kGap, height = rows * (h + kGap) - kGap;
  std::vector<std::uint8_t> grey(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0);
  for (int s = 0; s < slices; ++s) {
    const int k = static_cast<int>((s + 0.5) * n.z() / slices), left = s % kColumns * (w + kGap),
              top = s / kColumns * (h + kGap);
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x) {
        const auto i = static_cast<std::size_t>((x + 0.5) * n.x() / w),
                   j = static_cast<std::size_t>((h - y - 0.5) * n.y() / h);
        const double v = image.values[i + static_cast<std::size_t>(n.x()) *
                                              (j + static_cast<std::size_t>(n.y()) * static_cast<std::size_t>(k))];
        grey[static_cast<std::size_t>(top + y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(left + x)] =
            static_cast<std::uint8_t>(std::lround(255.0 * (v - lo) / range));
      }
  }
  std::ofstream file(path, std::ios::binary);
  file << png(grey, static_cast<std::size_t>(width), static_cast<std::size_t>(height));
  file.close();
  if (!file) throw InputError(fmt::format("{}: the file cannot be written", path));
}

}  // namespace brim::cli
