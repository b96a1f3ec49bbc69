// The arithmetic of the loss against a photo, shared by ssim.cpp and cuda_loss.h, for one number
// or, with the lane type V of lanes.h, one per lane. A number is one channel of a pixel: x of the
// image, y of the photo. The reference is photo_loss in train/losses.py.
#pragma once
#include "lanes.h"

namespace {

constexpr int RADIUS = 5, TAPS = 2 * RADIUS + 1;  // of SSIM's window
constexpr float SSIM_C1 = 0.01f * 0.01f, SSIM_C2 = 0.03f * 0.03f;

// A Gaussian of sigma 1.5; the taps sum to 1.
MGS_FN float window_tap(int k) {
  constexpr float TAP[RADIUS + 1] = {0.00102838012f, 0.00759875821f, 0.0360007733f,
                                     0.109360687f,   0.213005543f,   0.266011715f};
  return TAP[k < RADIUS ? k : TAPS - 1 - k];
}

// What SSIM compares: x, y, x^2 + y^2 and x y, blurred.
template <class V>
struct Moments {
  V mean_x, mean_y, squares, product;
};

// The gradient by the moments that depend on x.
template <class V>
struct MomentGradients {
  V mean, squares, product;
};

// Sums of terms of the loss.
template <class V>
struct Terms {
  V absolute, unlike, squared;
};

// Adds the terms of a number and returns the gradient by its moments. `share` is that of the
// unlikeness in the loss.
template <class V>
MGS_FN MomentGradients<V> add_terms(V x, V y, V weight, const Moments<V>& of, float share,
                                    Terms<V>& terms) {
  V mean_x = of.mean_x, mean_y = of.mean_y, difference = x - y;
  V luminance = 2.0f * mean_x * mean_y + SSIM_C1;
  V contrast = 2.0f * (of.product - mean_x * mean_y) + SSIM_C2;
  V below_l = mean_x * mean_x + mean_y * mean_y + SSIM_C1;
  V below_c = of.squares - mean_x * mean_x - mean_y * mean_y + SSIM_C2;
  V inverse = 1.0f / (below_l * below_c), score = luminance * contrast * inverse;
  V grad = -share * weight, to_product = 2.0f * grad * inverse * luminance;
  V to_squares = -grad * score * inverse * below_l;
  V to_mean = 2.0f * grad * inverse * (mean_y * contrast - score * mean_x * below_c) -
              to_product * mean_y - 2.0f * to_squares * mean_x;
  terms.absolute += weight * select(difference < 0.0f, -difference, difference);
  terms.unlike += weight * (1.0f - score);
  terms.squared += weight * difference * difference;
  return {to_mean, to_squares, to_product};
}

// The gradient of |x - y| by x.
template <class V>
MGS_FN V sign_of_difference(V x, V y) {
  const V zero = {};
  return select(x > y, zero + 1.0f, select(x < y, zero - 1.0f, zero));
}

// The gradient of the loss by x. `blurred` are the gradients that add_terms returned, and `share`
// is that of the absolute difference.
template <class V>
MGS_FN V photo_gradient(V x, V y, V weight, const MomentGradients<V>& blurred, float share) {
  V found = blurred.mean + 2.0f * x * blurred.squares + y * blurred.product +
            share * weight * sign_of_difference(x, y);
  return select(weight > 0.0f, found, V{});
}

}  // namespace
