// Messages as words, for tests: numbers as they are, text as s and its bytes in hexadecimal, sequences with their
// length before them.
#ifndef STAND_IN_TEXT_HPP_
#define STAND_IN_TEXT_HPP_

#include <array>
#include <cstdio>
#include <cstdlib>
#include <istream>
#include <ostream>
#include <string>
#include <type_traits>
#include <vector>

namespace stand_in
{

template<class Number, std::enable_if_t<std::is_arithmetic_v<Number>, int> = 0>
void read(std::istream & in, Number & value)
{
  std::string word;
  in >> word;
  value = static_cast<Number>(std::strtod(word.c_str(), nullptr));
}

template<class Number, std::enable_if_t<std::is_arithmetic_v<Number>, int> = 0>
void write(std::ostream & out, const Number & value)
{
  char text[40];
  std::snprintf(text, sizeof text, " %.17g", static_cast<double>(value));
  out << text;
}

inline void read(std::istream & in, std::string & value)
{
  std::string word;
  in >> word;
  value.clear();
  for (std::size_t at = 1; at + 1 < word.size(); at += 2) {
    value += static_cast<char>(std::strtol(word.substr(at, 2).c_str(), nullptr, 16));
  }
}

inline void write(std::ostream & out, const std::string & value)
{
  out << " s";
  for (const char each : value) {
    char text[3];
    std::snprintf(text, sizeof text, "%02x", static_cast<unsigned char>(each));
    out << text;
  }
}

// Messages have these two as members; they are found before the members of sequences are.
template<class Message>
auto read(std::istream & in, Message & message) -> decltype(message.read_from(in))
{
  message.read_from(in);
}

template<class Message>
auto write(std::ostream & out, const Message & message) -> decltype(message.write_to(out))
{
  message.write_to(out);
}

template<class Item>
void read(std::istream & in, std::vector<Item> & items)
{
  double count = 0;
  read(in, count);
  items.resize(static_cast<std::size_t>(count));
  for (std::size_t index = 0; index < items.size(); ++index) {
    Item item{};
    read(in, item);
    items[index] = item;
  }
}

template<class Item>
void write(std::ostream & out, const std::vector<Item> & items)
{
  write(out, items.size());
  for (const Item & each : items) {
    write(out, each);
  }
}

template<class Item, std::size_t count>
void read(std::istream & in, std::array<Item, count> & items)
{
  for (Item & each : items) {
    read(in, each);
  }
}

template<class Item, std::size_t count>
void write(std::ostream & out, const std::array<Item, count> & items)
{
  for (const Item & each : items) {
    write(out, each);
  }
}

}  // namespace stand_in

#endif  // STAND_IN_TEXT_HPP_
