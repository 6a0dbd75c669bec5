# SPDX-License-Identifier: Apache-2.0
# Reads C++ sources as statements and prints those that declare mutable state: mutable, thread_local, const_cast,
# static or namespace-scope variables that are not const.

function reset() {
  scope = "N"       # the kinds of the open braces: Namespace, Class, other (a function or an initializer)
  statement = ""
  in_comment = 0
  raw_end = ""      # what ends the raw string that a line is inside of
}

# The line with its raw strings emptied; they may go on for lines.
function without_raw_strings(line,    out, end) {
  out = ""
  for (;;) {
    if (raw_end != "") {
      end = index(line, raw_end)
      if (!end) return out
      line = "\"\"" substr(line, end + length(raw_end))
      raw_end = ""
    }
    if (!match(line, /R"[^ ()\\\t"]*\(/)) return out line
    raw_end = ")" substr(line, RSTART + 2, RLENGTH - 3) "\""
    out = out substr(line, 1, RSTART - 1)
    line = substr(line, RSTART + RLENGTH)
  }
}

function has_word(text, word) { return text ~ ("(^|[^A-Za-z0-9_])" word "([^A-Za-z0-9_]|$)") }

# What is declared: the text before an initializer.
function declarator(text) {
  sub(/=([^=].*)?$/, "", text)
  return text
}

function is_constant(text) { return has_word(text, "const") || has_word(text, "constexpr") }

function offence(what) { print FILENAME ":" first_line ": " what }

function judge(text, ended_by,    head) {
  sub(/^__extension__ /, "", text)
  if (text !~ /[A-Za-z]/) return
  if (has_word(text, "mutable")) offence("mutable")
  if (has_word(text, "thread_local")) offence("thread_local")
  if (has_word(text, "const_cast")) offence("const_cast")
  head = declarator(text)
  if (index(head, "(") > 0 || is_constant(head)) return
  if (has_word(head, "static")) {
    offence("static variable")
    return
  }
  if (scope !~ /^N+$/ || has_word(head, "operator")) return
  if (head ~ /^(using|typedef|template|friend|extern|namespace|static_assert|class|struct|union|enum)[^A-Za-z0-9_]/) return
  if (head ~ /^(namespace|BINNACLE_[A-Z_]*)$/) return
  if (head ~ /[A-Za-z0-9_>*&][ ]+[*&]*[A-Za-z_]/) offence("variable at namespace scope")
}

function kind_of_brace(text) {
  if (has_word(text, "namespace") || text ~ /extern ""$/) return "N"
  if (text ~ /(^|[^A-Za-z0-9_])(class|struct|union|enum)[^A-Za-z0-9_]/ && index(text, "(") == 0) return "C"
  return "F"
}

FNR == 1 { reset() }

{
  line = without_raw_strings($0)
  gsub(/\\./, "", line)
  gsub(/'[^']'/, "0", line)
  gsub(/[0-9]'/, "0", line)
  gsub(/"[^"]*"/, "\"\"", line)
  if (!in_comment && line ~ /^[ \t]*#/) next

  n = length(line)
  for (i = 1; i <= n; ++i) {
    c = substr(line, i, 1)
    two = substr(line, i, 2)
    if (in_comment) {
      if (two == "*/") { in_comment = 0; ++i }
      continue
    }
    if (two == "//") break
    if (two == "/*") { in_comment = 1; ++i; continue }
    if (c == " " || c == "\t") {
      if (statement != "" && statement !~ / $/) statement = statement " "
      continue
    }
    if (c == "{") {
      sub(/ $/, "", statement)
      judge(statement, c)
      scope = scope kind_of_brace(statement)
      statement = ""
    } else if (c == "}") {
      judge(statement, c)
      if (length(scope) > 1) scope = substr(scope, 1, length(scope) - 1)
      statement = ""
    } else if (c == ";") {
      sub(/ $/, "", statement)
      judge(statement, c)
      statement = ""
    } else if (c == ":" && statement ~ /^(public|protected|private)$/) {
      statement = ""
    } else {
      if (statement == "") first_line = FNR
      statement = statement c
    }
  }
  if (statement != "" && statement !~ / $/) statement = statement " "
}
