#include "rules/sandbox.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

#include "rules/test_records.hpp"

namespace ballbar {
namespace {

std::string run(const std::string& source) {
  return test::outcome([&] { run_sandboxed(source, [](lua_State*) {}); });
}

// A script has one way of saying something to a test: an error.
std::string value_of(const std::string& expression) {
  const std::string said = run("error(tostring(" + expression + "), 0)");
  return said.substr(said.find(' ') + 1);
}

struct Attack {
  const char* what;
  std::string script;
  const char* answer;  // a part of the message
};

void PrintTo(const Attack& attack, std::ostream* out) { *out << attack.what; }

class SandboxAttack : public testing::TestWithParam<Attack> {};

// Each of these hangs, exhausts the machine or escapes in a plain Lua. A hang here is a failure by the
// runner's time limit.
TEST_P(SandboxAttack, EndsInAnErrorWithTheLine) {
  const std::string said = run("\n" + GetParam().script);
  EXPECT_NE(said.find(GetParam().answer), std::string::npos) << said;
  EXPECT_EQ(said.substr(0, 3), "2: ") << said;
}

const std::string kLongString = "local s = 'aaaaaaaaaaaaaaaa' for i = 1, 7 do s = s .. s end ";  // 2 KiB
const std::string kLongTable = "local t = {} for i = 1, 3500 do t[i] = i end ";

INSTANTIATE_TEST_SUITE_P(
    Endless, SandboxAttack,
    testing::Values(
        Attack{"loop", "while true do end", "instruction budget"},
        Attack{"goto", "::again:: goto again", "instruction budget"},
        Attack{"for to infinity", "for i = 1, math.huge do end", "instruction budget"},
        Attack{"tail calls", "local function f() return f() end f()", "instruction budget"},
        Attack{"pcall around a loop", "pcall(function() while true do end end)", "blocked function: pcall"},
        Attack{"xpcall with a looping handler", "xpcall(error, function() while true do end end)",
               "blocked function: xpcall"},
        Attack{"string.rep as a method", "local s = (''):rep(1e11)", "blocked function: string.rep"},
        Attack{"pattern", "local s = ('a'):find('a*a*a*a*b')", "blocked function: string.find"},
        Attack{"table.move", "table.move({}, 1, 1e11, 2)", "blocked function: table.move"},
        Attack{"__len for table.insert", "table.insert(setmetatable({}, {}), 1)",
               "blocked function: setmetatable"},
        Attack{"__gc", "setmetatable({}, { __gc = function() while true do end end })",
               "blocked function: setmetatable"},
        Attack{"sort of a long table, again and again", kLongTable + "while true do table.sort(t) end",
               "instruction budget"},
        Attack{"insert at the front of a long table",
               kLongTable + "while true do table.insert(t, 1, 0) table.remove(t, 1) end",
               "instruction budget"},
        Attack{"concat over a range", "table.concat({}, '', 1, 1e11)", "instruction budget"},
        Attack{"unpack of a range", "local n = select('#', table.unpack({}, 1, 1e8))", "instruction budget"},
        Attack{"long strings, again and again", kLongString + "while true do local u = s:upper() end",
               "instruction budget"},
        Attack{"contains, again and again", kLongString + "while true do string.contains(s, s .. 'b') end",
               "instruction budget"},
        Attack{"bad comparator", kLongTable + "table.sort(t, function() return true end)",
               "invalid order function"}));

INSTANTIATE_TEST_SUITE_P(
    Memory, SandboxAttack,
    testing::Values(
        Attack{"string doubling", "local s = 'x' while true do s = s .. s end", "memory budget"},
        Attack{"one table", "local t = {} for i = 1, 1e9 do t[i] = i end", "memory budget"},
        Attack{"many tables", "local t = {} while true do t = { t, 1, 2, 3 } end", "memory budget"},
        Attack{"many strings", "local t = {} for i = 1, 1e9 do t = { t, string.format('%09d', i) } end",
               "memory budget"},
        Attack{"deep recursion", "local function f() return 1 + f() end f()", "memory budget"},
        Attack{"living at the edge",
               "local all = {} for k = 1, 900 do all[k] = {} for i = 1, 240 do all[k][i] = i end end "
               "while true do local t = { 1, 2, 3 } end",
               "memory budget"}));

INSTANTIATE_TEST_SUITE_P(
    Escape, SandboxAttack,
    testing::Values(Attack{"os", "os.execute('true')", "blocked function: os.execute"},
                    Attack{"io", "io.open('/etc/passwd')", "blocked function: io.open"},
                    Attack{"require", "require('os')", "blocked function: require"},
                    Attack{"load", "load('return 1')()", "blocked function: load"},
                    Attack{"dofile", "dofile('/etc/passwd')", "blocked function: dofile"},
                    Attack{"debug", "debug.sethook()", "blocked function: debug.sethook"},
                    Attack{"coroutine", "coroutine.wrap(error)()", "blocked function: coroutine.wrap"},
                    Attack{"collectgarbage", "collectgarbage('stop')", "blocked function: collectgarbage"},
                    Attack{"print", "print('x')", "blocked function: print"},
                    Attack{"_G", "_G.x = 1", "blocked function: _G"},
                    Attack{"string metatable", "getmetatable('').__index = nil",
                           "blocked function: getmetatable"},
                    Attack{"dump", "string.dump(error)", "blocked function: string.dump"},
                    Attack{"random", "local x = math.random()", "blocked function: math.random"},
                    Attack{"misspelt name", "local x = limit", "unknown name 'limit'"}));

TEST(Sandbox, RefusesBytecodeNestedParenthesesAndBadSyntax) {
  EXPECT_NE(run("\x1bLuaS").find("attempt to load a binary chunk"), std::string::npos) << run("\x1bLuaS");
  const std::string nested = "local x = " + std::string(5000, '(') + "1" + std::string(5000, ')');
  EXPECT_NE(run(nested).find("overflow"), std::string::npos) << run(nested);
  EXPECT_EQ(run("\nx = = 1"), "2: unexpected symbol near '='");
}

TEST(Sandbox, HoldsExactlyTheAllowList) {
  const std::string names =
      "local function names(t) local n = {} for k in pairs(t) do n[#n + 1] = k end table.sort(n) return "
      "table.concat(n, ' ') end "
      "error(names(";
  EXPECT_EQ(run(names + "_ENV), 0)"),
            "1: assert error ipairs math next pairs select string table tonumber tostring type");
  EXPECT_EQ(run(names + "string), 0)"), "1: byte contains format len lower sub upper");
  EXPECT_EQ(run(names + "table), 0)"), "1: concat insert remove sort unpack");
  EXPECT_EQ(run(names + "math), 0)"),
            "1: abs acos asin atan ceil cos deg exp floor fmod huge log max min modf pi rad sin sqrt tan "
            "tointeger type");
}

TEST(Sandbox, WhatItAllowsDoesWhatLuaSays) {
  EXPECT_EQ(value_of("string.format('%.1f', 2.25 * 2)"), "4.5");
  EXPECT_EQ(value_of("('Abc'):upper() .. ('Abc'):sub(2) .. #'abc'"), "ABCbc3");
  EXPECT_EQ(value_of("string.contains('lrmate-1', 'mate')"), "true");
  EXPECT_EQ(value_of("('a.b'):contains('a*b')"), "false");
  EXPECT_EQ(value_of("math.max(3, 1, 2) + math.floor(2.7) + math.huge"), "inf");
  EXPECT_EQ(value_of("math.sqrt(3 ^ 2 + 4 ^ 2)"), "5.0");
  EXPECT_EQ(value_of("select('#', table.unpack({ 1, 2, 3 }))"), "3");
  EXPECT_EQ(value_of("tonumber('0x10') + select(2, 1, 5)"), "21");
  EXPECT_EQ(run("local t = { 3, 1, 2 } table.sort(t) table.insert(t, 4) table.remove(t, 1) "
                "error(table.concat(t, ','), 0)"),
            "1: 2,3,4");
}

TEST(Sandbox, TextIsNoNumberUnlessAsked) {
  EXPECT_EQ(run("local x = '1' + 1"), "1: attempt to perform arithmetic on a string value (constant '1')");
}

TEST(Sandbox, ErrorsNameTheLineWhereTheyAre) {
  EXPECT_EQ(run("local t\n\nlocal x = t.radial"), "3: attempt to index a nil value (local 't')");
  EXPECT_EQ(run("local function f()\n  error('too far')\nend\n\nf()"), "2: too far");
  EXPECT_EQ(run("\nerror({})"), "2: error(...) was called with a table instead of a text");
  EXPECT_EQ(run("\nerror('two\\nlines')"), "2: two lines");
  EXPECT_EQ(run("\nlocal t = {}\nt[0/0] = 1"), "3: table index is NaN");
  EXPECT_EQ(run("\n\ntable.sort(1)"), "3: bad argument #1 to 'sort' (table expected, got number)");
}

TEST(Sandbox, OneScriptLeavesNothingToTheNext) {
  EXPECT_EQ(run("x = 1 string.len = nil math.pi = 3"), "fine");
  EXPECT_EQ(run("local y = x"), "1: unknown name 'x'");
  EXPECT_EQ(value_of("('abc'):len()"), "3");
  EXPECT_EQ(value_of("math.pi > 3.14"), "true");
}

TEST(Sandbox, UsualRulesAreFarFromTheBudget) {
  EXPECT_EQ(run("local sum = 0 for i = 1, 100000 do sum = sum + i end"), "fine");
  EXPECT_EQ(run("local t = {} for i = 1, 500 do t[i] = { i, i, i } end"), "fine");
}

TEST(Sandbox, AcceptsTheByteOrderMarkOfWindowsEditors) {
  EXPECT_EQ(run("\xEF\xBB\xBFlocal x = 1\r\n"), "fine");
}

TEST(Sandbox, ExceptionsOfTheCallerComeThroughUnchanged) {
  EXPECT_THROW(run_sandboxed("return 1", [](lua_State*) { throw std::logic_error("mine"); }),
               std::logic_error);
  EXPECT_EQ(
      test::outcome([] { run_sandboxed("return 1", [](lua_State*) { throw ScriptError(7, "mine"); }); }),
      "7: mine");
}

}  // namespace
}  // namespace ballbar
