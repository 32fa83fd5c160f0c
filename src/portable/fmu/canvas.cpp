#include "portable/fmu/canvas.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace mimbre::portable {
namespace {

/// From a point to a stroke's middle line, or of a filled circle to its edge (negative inside).
double distance(const Stroke& s, double x, double y) {
  const double dx = s.to[0] - s.from[0], dy = s.to[1] - s.from[1], length = dx * dx + dy * dy;
  const double px = x - s.from[0], py = y - s.from[1];
  const double along = length > 0 ? std::clamp((px * dx + py * dy) / length, 0.0, 1.0) : 0.0;
  const double ex = px - along * dx, ey = py - along * dy, off = std::sqrt(ex * ex + ey * ey);
  if (s.radius == 0) return off;
  return s.width > 0 ? std::abs(off - s.radius) : off - s.radius;
}

/// The share of a pixel that a stroke covers.
double cover(const Stroke& s, double x, double y) {
  return std::clamp(0.5 * s.width - distance(s, x, y) + 0.5, 0.0, 1.0);
}

/// Lays a colour over a pixel: red, green, blue, opacity.
void lay_over(const Colour& colour, double share, char* pixel) {
  const auto was = [&](int c) { return static_cast<double>(static_cast<unsigned char>(pixel[c])); };
  const double under = was(3) / 255 * (1 - share), opaque = share + under;
  const std::array<unsigned char, 3> laid{colour.r, colour.g, colour.b};
  for (int c = 0; c < 3; ++c)
    pixel[c] = static_cast<char>(static_cast<unsigned char>(
        (laid[static_cast<std::size_t>(c)] * share + was(c) * under) / opaque + 0.5));
  pixel[3] = static_cast<char>(static_cast<unsigned char>(255 * opaque + 0.5));
}

/// Rows of pixels, each behind a zero: without a filter.
std::string picture(const Canvas& canvas) {
  const int n = canvas.pixels;
  const std::size_t row = static_cast<std::size_t>(4 * n + 1);
  std::string rows(static_cast<std::size_t>(n) * row, '\0');
  for (const Stroke& s : canvas.strokes) {
    const double reach = s.radius + 0.5 * s.width + 1;
    const auto range = [&](double a, double b) {
      const double low = std::clamp(std::min(a, b) - reach, 0.0, static_cast<double>(n)),
                   high = std::clamp(std::max(a, b) + reach + 1, 0.0, static_cast<double>(n));
      return std::array{static_cast<int>(low), static_cast<int>(high)};
    };
    const std::array across = range(s.from[0], s.to[0]), down = range(s.from[1], s.to[1]);
    for (int j = down[0]; j < down[1]; ++j)
      for (int i = across[0]; i < across[1]; ++i) {
        const double share = cover(s, i + 0.5, j + 0.5);
        if (share > 0)
          lay_over(s.colour, share,
                   rows.data() + static_cast<std::size_t>(j) * row + 1 + static_cast<std::size_t>(4 * i));
      }
  }
  return rows;
}

std::string big_endian(unsigned long x) {
  std::string out;
  for (int shift = 24; shift >= 0; shift -= 8) out += static_cast<char>(x >> shift & 0xff);
  return out;
}

std::string chunk(const std::string& name, const std::string& data) {
  const std::string body = name + data;
  const unsigned long sum =
      crc32(0, reinterpret_cast<const Bytef*>(body.data()), static_cast<uInt>(body.size()));
  return big_endian(data.size()) + body + big_endian(sum);
}

std::string deflated(const std::string& bytes) {
  uLongf size = compressBound(bytes.size());
  std::string out(size, '\0');
  constexpr int level = 9;
  if (compress2(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
                bytes.size(), level) != Z_OK)
    throw std::runtime_error("a picture cannot be compressed");
  out.resize(size);
  return out;
}

std::string hex(const Colour& c) { return fmt::format("#{:02x}{:02x}{:02x}", c.r, c.g, c.b); }

}  // namespace

std::string svg_of(const Canvas& canvas) {
  std::string out = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {0}\" stroke-linecap=\"round\">\n",
      canvas.pixels);
  for (const Stroke& s : canvas.strokes)
    if (s.radius == 0)
      out += fmt::format(
          "<line x1=\"{:.2f}\" y1=\"{:.2f}\" x2=\"{:.2f}\" y2=\"{:.2f}\" stroke=\"{}\" "
          "stroke-width=\"{}\"/>\n",
          s.from[0], s.from[1], s.to[0], s.to[1], hex(s.colour), s.width);
    else
      out += fmt::format(
          "<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"{:.2f}\" fill=\"{}\" stroke=\"{}\" "
          "stroke-width=\"{}\"/>\n",
          s.from[0], s.from[1], s.radius, s.width > 0 ? "none" : hex(s.colour),
          s.width > 0 ? hex(s.colour) : "none", s.width);
  return out + "</svg>\n";
}

std::string png_of(const Canvas& canvas) {
  const std::string signature = "\x89PNG\r\n\x1a\n";
  const auto size = static_cast<unsigned long>(canvas.pixels);
  const std::string head = big_endian(size) + big_endian(size) + std::string("\x08\x06\x00\x00\x00", 5);
  return signature + chunk("IHDR", head) + chunk("IDAT", deflated(picture(canvas))) + chunk("IEND", "");
}

}  // namespace mimbre::portable
