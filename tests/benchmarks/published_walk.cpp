// The random walk of Heitz et al. 2016, Algorithm 1, one walk at a time in single precision, with the
// sampling of visible slopes of its supplemental: what the walk of this project is timed against.
//
//     published_walk SLOPES MATERIAL ALPHA THETA WALKS
//
// prints the seconds that it took, and the energy of each of the first four orders, on both sides.
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

namespace {

constexpr float pi = 3.14159265f, half_inverse_root_pi = 0.28209479f;
constexpr float ior = 1.5f;
constexpr int most_facets = 1000;

struct Vector {
  float x, y, z;
};
Vector operator+(Vector a, Vector b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Vector operator*(float s, Vector a) { return {s * a.x, s * a.y, s * a.z}; }
float dot(Vector a, Vector b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vector unit(Vector a) { return (1 / std::sqrt(dot(a, a))) * a; }

struct Random {  // PCG 32, O'Neill 2014.
  std::uint64_t state = 42;
  float operator()() {
    const std::uint64_t old = state;
    state = old * 6364136223846793005ull + 1442695040888963407ull;
    const std::uint32_t mixed = std::uint32_t(((old >> 18) ^ old) >> 27), turn = old >> 59;
    return float(((mixed >> turn) | (mixed << (-turn & 31))) >> 8) * 0x1p-24f;
  }
};

// Giles 2012, in single precision.
float inverse_erf(float x) {
  float w = -std::log((1 - x) * (1 + x));
  const float centre[] = {2.81022636e-08f, 3.43273939e-07f, -3.5233877e-06f,
                          -4.39150654e-06f, 0.00021858087f, -0.00125372503f,
                          -0.00417768164f, 0.246640727f, 1.50140941f};
  const float tail[] = {-0.000200214257f, 0.000100950558f, 0.00134934322f,
                        -0.00367342844f, 0.00573950773f, -0.0076224613f,
                        0.00943887047f, 1.00167406f, 2.83297682f};
  const float* c = w < 5 ? centre : tail;
  w = w < 5 ? w - 2.5f : std::sqrt(w) - 3;
  float p = c[0];
  for (int i = 1; i < 9; ++i) p = p * w + c[i];
  return p * x;
}

struct Surface {
  bool beckmann;
  float alpha;

  float Lambda(Vector w) const {
    if (w.z > 0.9999f) return 0;
    if (w.z < -0.9999f) return -1;
    const float a = w.z / (std::sqrt(1 - w.z * w.z) * alpha);
    if (!beckmann) return 0.5f * (-1 + std::copysign(std::sqrt(1 + 1 / (a * a)), a));
    return 0.5f * (std::erf(a) - 1) + half_inverse_root_pi / a * std::exp(-a * a);
  }

  void beckmann_slopes(float theta, float U, float V, float& x, float& y) const {
    y = inverse_erf(2 * V - 1);
    const float s = std::sin(theta), c = std::cos(theta), a = c / s;
    const float area =
        0.5f * (std::erf(a) + 1) * c + half_inverse_root_pi * s * std::exp(-a * a);
    if (!(area > 1e-4f)) return void(x = y = 0);
    float low = -0.9999f, high = std::fmax(low, std::erf(a)), at = 0.5f * (low + high);
    for (int step = 0; step < 100 && high - low > 1e-5f; ++step) {
      if (!(at >= low && at <= high)) at = 0.5f * (low + high);
      const float slope = inverse_erf(at);
      const float below = half_inverse_root_pi * s * std::exp(-slope * slope) +
                          c * (0.5f + 0.5f * std::erf(slope));
      const float off = (slope >= a ? 1 : below / area) - U;
      if (std::fabs(off) < 1e-5f) break;
      (off > 0 ? high : low) = at;
      at -= off / (0.5f / area * (c - s * slope));
    }
    x = inverse_erf(std::fmin(high, std::fmax(low, at)));
  }

  void ggx_slopes(float theta, float U, float V, float& x, float& y) const {
    const float s = std::sin(theta), c = std::cos(theta), tan = s / c;
    const float area = 0.5f * (c + 1);
    if (!(area > 1e-4f)) return void(x = y = 0);
    const float A = 2 * U * area / c - 1, B = 1 / (A * A - 1);
    const float D = std::sqrt(std::fmax(0.0f, tan * tan * B * B - (A * A - tan * tan) * B));
    x = A < 0 || tan * B + D > 1 / tan ? tan * B - D : tan * B + D;
    const float side = V > 0.5f ? 1.0f : -1.0f, v = side * 2 * (V - 0.5f);
    const float z = v * (v * (v * 0.27385f - 0.73369f) + 0.46341f) /
                    (v * (v * (v * 0.093073f + 0.309420f) - 1) + 0.597999f);
    y = side * z * std::sqrt(1 + x * x);
  }

  Vector visible_normal(Vector wi, Random& random) const {
    const Vector stretched = unit({alpha * wi.x, alpha * wi.y, wi.z});
    const float theta = std::acos(stretched.z), phi = std::atan2(stretched.y, stretched.x);
    const float U = random(), V = random();
    float x, y;
    if (theta < 1e-4f) {
      const float r = std::sqrt(beckmann ? -std::log(U) : U / (1 - U));
      x = r * std::cos(2 * pi * V), y = r * std::sin(2 * pi * V);
    } else if (beckmann) {
      beckmann_slopes(theta, U, V, x, y);
    } else {
      ggx_slopes(theta, U, V, x, y);
    }
    const float c = std::cos(phi), s = std::sin(phi);
    const Vector m = {-alpha * (c * x - s * y), -alpha * (s * x + c * y), 1};
    if (!std::isfinite(m.x) || !std::isfinite(m.y))
      return wi.z > 0 ? Vector{0, 0, 1} : unit({wi.x, wi.y, 0});
    return unit(m);
  }
};

float fresnel(float c, float eta) {
  const float cos2 = 1 - (1 - c * c) / (eta * eta);
  if (cos2 <= 0) return 1;
  const float t = std::sqrt(cos2);
  const float parallel = (eta * c - t) / (eta * c + t), across = (c - eta * t) / (c + eta * t);
  return 0.5f * (parallel * parallel + across * across);
}

// Outside of the surface, where its heights are uniform from -1 to 1.
constexpr float outside = 2;

// [HHdD16] Algorithm 1; light inside sees the surface upside down.
float next_height(const Surface& surface, Vector w, float h, Random& random) {
  if (w.z > 0.9999f) return outside;
  const float U = random();
  if (w.z < -0.9999f) return 2 * U * 0.5f * (h + 1) - 1;
  if (std::fabs(w.z) < 1e-4f) return h;
  const float Lambda = surface.Lambda(w), C1 = std::fmin(1.0f, std::fmax(0.0f, 0.5f * (h + 1)));
  if (w.z > 0 && U > 1 - std::pow(C1, Lambda)) return outside;
  return 2 * (C1 / std::pow(1 - U, 1 / Lambda)) - 1;
}

Vector lambertian(Vector m, Random& random) {
  const float r = std::sqrt(random()), phi = 2 * pi * random();
  const float x = r * std::cos(phi), y = r * std::sin(phi), z = std::sqrt(1 - r * r);
  const float sign = std::copysign(1.0f, m.z), a = -1 / (sign + m.z), b = m.x * m.y * a;
  const Vector t1 = {1 + sign * m.x * m.x * a, sign * b, -sign * m.x};
  const Vector t2 = {b, sign + m.y * m.y * a, -m.y};
  return x * t1 + y * t2 + z * m;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 6) return 2;
  const Surface surface = {std::string(argv[1]) == "beckmann", std::strtof(argv[3], nullptr)};
  const std::string material = argv[2];
  const bool mirror = material == "conductor", glass = material == "dielectric";
  const float theta = std::strtof(argv[4], nullptr);
  const long walks = std::atol(argv[5]);
  long count[5] = {};
  Random random;
  const auto start = std::chrono::steady_clock::now();
  for (long i = 0; i < walks; ++i) {
    Vector w = {-std::sin(theta), 0, -std::cos(theta)};
    float h = 1 + 1e-6f;
    bool inside = false;
    for (int facet = 0; facet < most_facets; ++facet) {
      if (inside) {
        h = -next_height(surface, -1 * w, -h, random);
        if (h <= -outside) h = outside;
      } else {
        h = next_height(surface, w, h, random);
      }
      if (h >= outside) {
        ++count[facet > 4 ? 4 : facet - 1];
        break;
      }
      Vector m = surface.visible_normal(inside ? w : -1 * w, random);
      if (mirror) {
        w = w + (-2 * dot(w, m)) * m;
      } else if (!glass) {
        w = lambertian(m, random);
      } else {
        const float eta = inside ? 1 / ior : ior;
        if (inside) m = -1 * m;
        const float c = -dot(w, m);
        if (random() < fresnel(c, eta)) {
          w = w + (2 * c) * m;
        } else {
          const float t = std::sqrt(std::fmax(0.0f, 1 - (1 - c * c) / (eta * eta)));
          w = (1 / eta) * w + (c / eta - t) * m;
          inside = !inside;
        }
      }
      w = unit(w);
    }
  }
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  std::printf("%.6f", took.count());
  for (int k = 0; k < 4; ++k) std::printf(" %.6f", double(count[k]) / double(walks));
  std::printf("\n");
}
