#include "regraft/accel/absence.h"

#include <gtest/gtest.h>

namespace regraft::test {
namespace {

/// Frames without rays after which the absence counts as lasting.
int patience(accel::Absence absence) {
  int frames = 0;
  for (absence.note(true); !absence.is_lasting(); ++frames) absence.note(false);
  return frames;
}

TEST(Absence, TwoFramesInARowThatRaysKeptAwayAreLasting) {
  accel::Absence absence;
  EXPECT_FALSE(absence.is_lasting());
  for (const bool is_met : {false, true, false}) absence.note(is_met);
  EXPECT_FALSE(absence.is_lasting());
  absence.note(false);
  EXPECT_TRUE(absence.is_lasting());
}

TEST(Absence, AMeshAtTheEdgeOfTheViewIsLeftBehindEverMoreRarely) {
  accel::Absence absence;
  int before = patience(absence);
  for (int i = 0; i < 10; ++i) {
    while (!absence.is_lasting()) absence.note(false);
    absence.end();
    const int now = patience(absence);
    EXPECT_EQ(now, std::min(2 * before, 32));
    before = now;
  }
}

TEST(Absence, OneThatWasWorthItIsTrustedAgain) {
  accel::Absence absence;
  for (int i = 0; i < 3; ++i) absence.end();
  for (int i = 0; i < 100; ++i) absence.note(false);
  absence.end();
  EXPECT_FALSE(absence.is_lasting());
  EXPECT_EQ(patience(absence), 2);
}

}  // namespace
}  // namespace regraft::test
