#pragma once
#include <algorithm>
#include <cstddef>
#include <initializer_list>
#include <iterator>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/image_space.h"

namespace mimbre {

/// A sequence of elements, grown on the heap like a std::vector; what is copied while an ImageSpace is in use
/// lies in that space, with the elements' own arrays behind it, and cannot grow.
template <class T>
class Array {
 public:
  using value_type = T;
  using iterator = T*;
  using const_iterator = const T*;

  Array() = default;
  explicit Array(std::size_t count, const T& value = T()) { assign(count, value); }
  Array(std::initializer_list<T> values) { append(values.begin(), values.end()); }
  Array(const std::vector<T>& values) { append(values.begin(), values.end()); }  // NOLINT: stands for it
  Array(const Array& other) {
    if (other.empty()) return;
    void* place = nullptr;
    if (ImageSpace* space = ImageSpace::current()) place = space->take(other.size_ * sizeof(T));
    if (!place) {
      append(other.begin(), other.end());
      return;
    }
    data_ = static_cast<T*>(place);
    size_ = other.size_;
    ImageSpace& space = *ImageSpace::current();
    space.note_pointer(&data_);
    for (std::size_t k = 0; k < size_; ++k) {
      new (data_ + k) T(other[k]);
      if (space.plain()) clear_padding(data_[k]);
    }
  }
  Array(Array&& other) noexcept { swap(other); }
  Array& operator=(const Array& other) {
    if (this == &other) return *this;
    clear();
    append(other.begin(), other.end());
    return *this;
  }
  Array& operator=(Array&& other) noexcept {
    swap(other);
    return *this;
  }
  ~Array() {
    if (capacity_ == 0) return;
    clear();
    release(data_);
  }

  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  T* data() { return data_; }
  const T* data() const { return data_; }
  T* begin() { return data_; }
  T* end() { return data_ + size_; }
  const T* begin() const { return data_; }
  const T* end() const { return data_ + size_; }
  T& operator[](std::size_t k) { return data_[k]; }
  const T& operator[](std::size_t k) const { return data_[k]; }
  T& front() { return *data_; }
  const T& front() const { return *data_; }
  T& back() { return data_[size_ - 1]; }
  const T& back() const { return data_[size_ - 1]; }

  template <class... Arguments>
  T& emplace_back(Arguments&&... arguments) {
    T made{std::forward<Arguments>(arguments)...};  // before what it may refer to is moved
    if (size_ == capacity_) grow(std::max<std::size_t>(4, 2 * size_));
    T* place = new (data_ + size_) T(std::move(made));
    ++size_;
    return *place;
  }
  void push_back(const T& value) { emplace_back(value); }
  void push_back(T&& value) { emplace_back(std::move(value)); }
  template <class Iterator>
  void append(Iterator first, Iterator last) {
    reserve(size_ + static_cast<std::size_t>(std::distance(first, last)));
    for (; first != last; ++first) emplace_back(*first);
  }
  void pop_back() { data_[--size_].~T(); }
  void reserve(std::size_t count) {
    if (count > capacity_) grow(count);
  }
  void resize(std::size_t count, const T& value = T()) {
    reserve(count);
    while (size_ > count) pop_back();
    while (size_ < count) emplace_back(value);
  }
  void assign(std::size_t count, const T& value) {
    const T kept = value;
    clear();
    resize(count, kept);
  }
  void truncate(const T* end) {
    while (data_ + size_ > end) pop_back();
  }
  void clear() { truncate(data_); }
  template <class Iterator, class = typename std::iterator_traits<Iterator>::iterator_category>
  void assign(Iterator first, Iterator last) {
    clear();
    append(first, last);
  }

 private:
  void grow(std::size_t count) {
    T* to = static_cast<T*>(::operator new (count * sizeof(T), std::align_val_t{ImageSpace::alignment}));
    for (std::size_t k = 0; k < size_; ++k) {
      new (to + k) T(std::move(data_[k]));
      data_[k].~T();
    }
    if (capacity_ > 0) release(data_);
    data_ = to;
    capacity_ = count;
  }
  static void release(T* from) {
    ::operator delete (static_cast<void*>(from), std::align_val_t{ImageSpace::alignment});
  }
  void swap(Array& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    std::swap(capacity_, other.capacity_);
  }

  T* data_ = nullptr;
  std::size_t size_ = 0;
  std::size_t capacity_ = 0;  ///< 0: empty or in an image, not to be freed
};

template <class T>
bool operator==(const Array<T>& a, const Array<T>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end());
}

}  // namespace mimbre
