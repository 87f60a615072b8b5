// Visible normals of [HHdD16 impl.] Section 2 where they are simplest, seen from the zenith: the
// check for slopes that are not finite stands in the program, and a compiler that was told that
// there are none leaves it out. Prints how many normals are not finite.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <random>

static bool finite_bits(float x) {  // By the exponent, which no option makes the compiler forget.
  std::uint32_t bits;
  std::memcpy(&bits, &x, sizeof bits);
  return (bits & 0x7f800000u) != 0x7f800000u;
}

int main() {
  std::mt19937 generator(1);
  std::uniform_int_distribution<int> numbers(0, 1 << 12);  // Both ends of [0, 1] are drawn.
  const float alpha = 0.5f;
  int bad = 0;
  for (int i = 0; i < 1000000; ++i) {
    const float U1 = numbers(generator) / 4096.0f, U2 = numbers(generator) / 4096.0f;
    const float r = std::sqrt(-std::log(U1)), phi = 6.28318530718f * U2;
    const float slope_x = alpha * r * std::cos(phi), slope_y = alpha * r * std::sin(phi);
    float m[3] = {-slope_x, -slope_y, 1.0f};
    if (slope_x != slope_x || !std::isfinite(slope_x)) m[0] = m[1] = 0.0f;
    const float length = std::sqrt(m[0] * m[0] + m[1] * m[1] + m[2] * m[2]);
    for (float& c : m) c /= length;
    bad += !(finite_bits(m[0]) && finite_bits(m[1]) && finite_bits(m[2]));
  }
  std::printf("%d\n", bad);
}
