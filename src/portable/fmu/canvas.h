#pragma once
#include <array>
#include <string>
#include <vector>

/// Drawings of a few lines and circles.
namespace mimbre::portable {

struct Colour {
  unsigned char r = 0, g = 0, b = 0;
};

/// In pixels from the upper left corner.
struct Stroke {
  std::array<double, 2> from, to;  ///< of a circle both are its centre
  double radius = 0;               ///< of a circle; 0: a line
  double width = 1;                ///< 0: a filled circle
  Colour colour;
};

/// A square of so many pixels, transparent but for the strokes; later ones cover earlier ones.
struct Canvas {
  int pixels = 256;
  std::vector<Stroke> strokes;
};

std::string svg_of(const Canvas& canvas);
/// Portable network graphics (ISO/IEC 15948), with eight bits each of red, green, blue and opacity.
std::string png_of(const Canvas& canvas);

}  // namespace mimbre::portable
