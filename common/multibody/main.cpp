#include <cstdio>
#include <exception>
#include <fstream>
#include <stdexcept>

#include "common/multibody/model_text.hpp"

// Writes the equations of a description as C++:  rb-derive-model DESCRIPTION.toml HEADER.hpp
int main(int argc, char** argv) {
  using namespace roadbalance;
  try {
    if (argc != 3) throw std::invalid_argument("usage: rb-derive-model DESCRIPTION.toml HEADER.hpp");
    std::ofstream header(argv[2], std::ios::binary);
    header << cpp_text(derive(Description::read_file(argv[1])));
    if (!header.flush()) throw std::runtime_error(std::string("cannot write ") + argv[2]);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "rb-derive-model: %s\n", error.what());
    return 1;
  }
}
