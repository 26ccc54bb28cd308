// Line ends and brackets, as in improv_core/syntax/statements.py. A statement ends with its line unless a bracket is
// open. A line that begins like a statement always starts one, so that a missing bracket does not swallow the rest.

#include "tree_sitter/alloc.h"
#include "tree_sitter/parser.h"

#include <string.h>

enum { END, LINE_BREAK, OPEN_GROUP, CLOSE_GROUP, OPEN_SQUEEZE, CLOSE_SQUEEZE };

typedef struct {
  uint32_t open_brackets;
} Scanner;

static bool is_blank(int32_t c) { return c == ' ' || c == '\t' || c == 0xFEFF; }

static bool is_line_end(int32_t c) { return c == '\n' || c == '\r'; }

static bool is_digit(int32_t c) { return '0' <= c && c <= '9'; }

// Beyond ASCII, all but spaces and general punctuation are letters: iswalpha() knows none of them in the C locale.
static bool is_letter(int32_t c) {
  if (c < 0x80) return ('a' <= c && c <= 'z') || ('A' <= c && c <= 'Z') || c == '_';
  return c >= 0xAA && c != 0x3000 && c != 0xFEFF && !(0x2000 <= c && c < 0x2070);
}

static void skip_blanks(TSLexer *lexer) {
  while (is_blank(lexer->lookahead)) lexer->advance(lexer, true);
}

static void skip_line_end(TSLexer *lexer) {
  bool is_carriage_return = lexer->lookahead == '\r';
  lexer->advance(lexer, false);
  if (is_carriage_return && lexer->lookahead == '\n') lexer->advance(lexer, false);
}

// Whether the following text begins like a statement: `beat NUMBER`, `NAME =` or `NAME … $`.
static bool begins_statement(TSLexer *lexer) {
  if (!is_letter(lexer->lookahead)) return false;
  const char *rest_of_beat = "beat";
  bool is_beat = true;
  while (is_letter(lexer->lookahead) || is_digit(lexer->lookahead)) {
    is_beat = is_beat && lexer->lookahead == *rest_of_beat++;
    lexer->advance(lexer, false);
  }
  is_beat = is_beat && !*rest_of_beat && is_blank(lexer->lookahead);
  skip_blanks(lexer);
  int32_t next = lexer->lookahead;
  if (next == '=' || (is_beat && (is_digit(next) || next == '-' || next == '+' || next == '.'))) return true;
  while (!lexer->eof(lexer) && !is_line_end(lexer->lookahead)) {
    switch (lexer->lookahead) {
      case '$': return true;
      case '(': case ')': case '[': case ']': case '=': case '|': case '#': return false;
    }
    lexer->advance(lexer, false);
  }
  return false;
}

// Takes every line end and bracket, even where the grammar does not expect it, so that an error stays in its statement.
bool tree_sitter_improv_external_scanner_scan(void *payload, TSLexer *lexer, const bool *valid_symbols) {
  (void)valid_symbols;
  uint32_t *open_brackets = &((Scanner *)payload)->open_brackets;
  skip_blanks(lexer);
  int32_t next = lexer->lookahead;

  if (is_line_end(next)) {
    skip_line_end(lexer);
    lexer->mark_end(lexer);
    while (*open_brackets && (is_blank(lexer->lookahead) || is_line_end(lexer->lookahead))) {
      lexer->advance(lexer, false);
    }
    if (!*open_brackets || begins_statement(lexer)) {
      *open_brackets = 0;
      lexer->result_symbol = END;
    } else {
      lexer->result_symbol = LINE_BREAK;
    }
    return true;
  }

  if (next == '(' || next == '[') {
    ++*open_brackets;
    lexer->result_symbol = next == '(' ? OPEN_GROUP : OPEN_SQUEEZE;
  } else if (next == ')' || next == ']') {
    if (*open_brackets) --*open_brackets;
    lexer->result_symbol = next == ')' ? CLOSE_GROUP : CLOSE_SQUEEZE;
  } else {
    return false;
  }
  lexer->advance(lexer, false);
  return true;
}

void *tree_sitter_improv_external_scanner_create(void) { return ts_calloc(1, sizeof(Scanner)); }

void tree_sitter_improv_external_scanner_destroy(void *payload) { ts_free(payload); }

unsigned tree_sitter_improv_external_scanner_serialize(void *payload, char *buffer) {
  memcpy(buffer, payload, sizeof(Scanner));
  return sizeof(Scanner);
}

void tree_sitter_improv_external_scanner_deserialize(void *payload, const char *buffer, unsigned length) {
  memset(payload, 0, sizeof(Scanner));
  if (length == sizeof(Scanner)) memcpy(payload, buffer, length);
}
