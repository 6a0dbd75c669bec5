// SPDX-License-Identifier: Apache-2.0
#include "attempt.hpp"

#include <exception>

#include "binnacle/testing.hpp"

namespace binnacle::conform {

void attempt(const Check& check, Trial& trial, const std::function<std::string()>& stage,
             const std::function<void(const Skip&)>& skipped) {
  const auto during = [&] {
    const std::string call = stage();
    return call.empty() ? call : " in " + call + "()";
  };
  try {
    check.run(trial);
  } catch (const Skip& skip) {
    skipped(skip);
  } catch (const OpenRefused& refusal) {
    const std::string text = refusal.what();
    if (text.find(" threw: ") == std::string::npos)
      skipped({"open() refuses its example: " + text, true});
    else
      trial.fail(text, "; throw ComponentError for what is refused");
  } catch (const testing::CallThrew& thrown) {
    trial.fail(thrown.what());
  } catch (const std::exception& error) {
    trial.fail("an exception crosses", during(), ": ", error.what());
  } catch (...) {
    trial.fail("something that is not a std::exception crosses", during());
  }
}

}  // namespace binnacle::conform
