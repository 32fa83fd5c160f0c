#include "base/hdf5.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace mimbre {
namespace {

/// A damaged header that announces more values than lie in it.
TEST(Hdf5, ReadsNoMoreThanACompactDatasetHas) {
  const auto path = std::filesystem::temp_directory_path() / ("mimbre-compact-" + std::to_string(getpid()));
  const hsize_t count = 4;
  const std::array<double, 4> values{1, 2, 3, 4};
  {
    const hdf5::Handle file(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT));
    const hdf5::Handle space(H5Screate_simple(1, &count, nullptr)), creation(H5Pcreate(H5P_DATASET_CREATE));
    H5Pset_layout(creation.get(), H5D_COMPACT);
    const hdf5::Handle data(H5Dcreate2(file.get(), "a", H5T_NATIVE_DOUBLE, space.get(), H5P_DEFAULT,
                                       creation.get(), H5P_DEFAULT));
    H5Dwrite(data.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
  }
  const auto opens = [&] {
    const hdf5::Quiet quiet;
    const hdf5::Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT));
    return hdf5::open_dataset(file.get(), "a").valid();
  };
  EXPECT_TRUE(opens());
  std::ifstream in(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(in), {}};
  // Its size along the axis, and the largest that may be.
  const std::array<hsize_t, 2> size{count, count}, larger{140, 140};
  const auto at = bytes.find(std::string(reinterpret_cast<const char*>(size.data()), sizeof size));
  ASSERT_NE(at, std::string::npos);
  std::memcpy(&bytes[at], larger.data(), sizeof larger);
  std::ofstream(path, std::ios::binary) << bytes;
  EXPECT_FALSE(opens());
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace mimbre
