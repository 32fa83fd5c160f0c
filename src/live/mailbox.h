#pragma once
#include <array>
#include <atomic>
#include <cstddef>
#include <vector>

/// How threads hand each other things without locks: neither ever waits for the other.
namespace mimbre::live {

/// Of the only thread that changes it.
template <class Number>
void increase(std::atomic<Number>& number, Number by) {
  number.store(number.load(std::memory_order_relaxed) + by, std::memory_order_relaxed);
}

/// The newest of what one thread writes, for one that reads: three places, of which each thread has one and
/// the third is exchanged. What was not read in time is overwritten.
template <class T>
class Newest {
 public:
  explicit Newest(const T& example = T()) { places_.fill(example); }

  /// The writer's place: filled, and then published.
  T& place() { return places_[writing_]; }
  void publish() { writing_ = exchanged_.exchange(writing_ | fresh, std::memory_order_acq_rel) & index; }

  /// Of the reader: the newest of what was published, which stays as it is until the next call. `news`: it is
  /// another than that of the call before.
  const T& read(bool& news) {
    news = (exchanged_.load(std::memory_order_relaxed) & fresh) != 0;
    if (news) reading_ = exchanged_.exchange(reading_, std::memory_order_acq_rel) & index;
    return places_[reading_];
  }

 private:
  static constexpr unsigned index = 3, fresh = 4;
  std::array<T, 3> places_;
  std::atomic<unsigned> exchanged_{1};
  unsigned writing_ = 0, reading_ = 2;
};

/// A queue from one thread to another, of things that are made once and used again. Full, it takes no more.
template <class T>
class Queue {
 public:
  explicit Queue(std::size_t capacity, const T& example = T()) : places_(capacity + 1, example) {}

  /// Of the writer: a place to fill, then to be pushed; null where the reader is so far behind that there is
  /// none.
  T* place() {
    const std::size_t at = written_.load(std::memory_order_relaxed);
    return after(at) == read_.load(std::memory_order_acquire) ? nullptr : &places_[at];
  }
  void push() { written_.store(after(written_.load(std::memory_order_relaxed)), std::memory_order_release); }
  /// False where it is full.
  bool push(const T& thing) {
    T* const free = place();
    if (!free) return false;
    *free = thing;
    push();
    return true;
  }

  /// Of the reader: the oldest, until it is popped; null where there is none.
  T* front() {
    const std::size_t at = read_.load(std::memory_order_relaxed);
    return at == written_.load(std::memory_order_acquire) ? nullptr : &places_[at];
  }
  void pop() { read_.store(after(read_.load(std::memory_order_relaxed)), std::memory_order_release); }

 private:
  std::size_t after(std::size_t at) const { return at + 1 == places_.size() ? 0 : at + 1; }
  std::vector<T> places_;
  std::atomic<std::size_t> written_{0}, read_{0};
};

}  // namespace mimbre::live
