// Splits the bytes of an input into arguments, and gives outputs of exactly the size that is asked.
#pragma once
#include <cstdint>
#include <cstdlib>
#include <cstring>

// Reads numbers from the front of an input; zeros beyond its end.
class Input {
 public:
  Input(const uint8_t* data, size_t size) : data_(data), left_(size) {}

  template <class T>
  T take() {
    T value{};
    size_t size = left_ < sizeof(T) ? left_ : sizeof(T);
    if (size) std::memcpy(&value, data_, size);
    data_ += size;
    left_ -= size;
    return value;
  }
  // A number from `least` to `most`.
  int64_t between(int64_t least, int64_t most) {
    return least + int64_t(take<uint32_t>() % uint64_t(most - least + 1));
  }
  const uint8_t* data() const { return data_; }
  size_t left() const { return left_; }

 private:
  const uint8_t* data_;
  size_t left_;
};

// Memory without a byte behind it, where AddressSanitizer sees an access that goes too far.
template <class T>
struct Exact {
  T* data;
  size_t size;
  explicit Exact(size_t size) : data(static_cast<T*>(std::malloc(size * sizeof(T)))), size(size) {
    if (!data && size) std::abort();
  }
  Exact(const Exact&) = delete;
  ~Exact() { std::free(data); }
  T& operator[](size_t i) { return data[i]; }
};
