// SPDX-License-Identifier: Apache-2.0
// What is kept of models' notes: equal ones once, with the first time; no more than there is room for.
#include <string>

#include "catch.hpp"
#include "filter/model_calls.hpp"

namespace note_book_test {

using namespace binnacle;
using internal::filter::NoteBook;

namespace {

const std::string type = "probe/model", here = "/filters/f/process/a", there = "/filters/f/process/b";

}  // namespace

TEST_CASE("equal notes of one component are one, with the time of the first", "[note_book]") {
  NoteBook book;
  for (const Time t : {5, 7, 9}) book.keep(type, here, "propagate", t, "it slips");
  book.keep(type, there, "propagate", 11, "it slips");
  book.keep(type, here, "propagate", 13, "it sticks");
  REQUIRE(book.notes().size() == 3);
  CHECK(book.notes()[0].count == 3);
  CHECK(book.notes()[0].first == 5);
  CHECK(*book.notes()[1].pointer == there);
  CHECK(book.notes()[1].count == 1);
  CHECK(std::string(book.notes()[2].text) == "it sticks");
  book.clear();
  CHECK(book.notes().empty());
}

TEST_CASE("a note is copied, and cut where it is too long", "[note_book]") {
  NoteBook book;
  std::string text(200, 'x');
  book.keep(type, here, "propagate", 1, text.c_str());
  book.keep(type, here, "propagate", 2, text.c_str());
  text[0] = 'y';
  REQUIRE(book.notes().size() == 1);
  CHECK(book.notes()[0].count == 2);
  CHECK(std::string(book.notes()[0].text) == std::string(119, 'x'));
}

TEST_CASE("notes beyond those there is room for are counted", "[note_book]") {
  NoteBook book;
  const auto* const place = book.notes().data();
  for (int i = 0; i < 100; ++i) book.keep(type, here, "propagate", i, std::to_string(i).c_str());
  CHECK(book.notes().size() == NoteBook::most);
  CHECK(book.notes().data() == place);
  CHECK(book.left_out() == 100 - static_cast<std::int64_t>(NoteBook::most));
  book.keep(type, here, "propagate", 200, "3");
  CHECK(book.notes()[3].count == 2);
}

}  // namespace note_book_test
