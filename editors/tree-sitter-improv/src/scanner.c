// Line ends and brackets, as in improv_core/syntax/statements.py, a statement's parameters, and the opening's words.
//
// A statement ends with its line unless a bracket is open or the next line of code begins with `||` or `else`. A line
// that begins like a statement always starts one, so that a missing bracket does not swallow the rest. The names in the
// head of a definition decide what the same names mean in its movement: `repeat n m` needs a number before a term.
// `at`, `is`, `room`, and `bar` are words only in lines that read like `ada at 1 2` and have no `=` or `$`, else names.

#include "tree_sitter/alloc.h"
#include "tree_sitter/parser.h"

#include <stddef.h>
#include <string.h>

enum {
  END,
  LINE_BREAK,
  OPEN_GROUP,
  CLOSE_GROUP,
  OPEN_SQUEEZE,
  CLOSE_SQUEEZE,
  DEFINED,
  NUMBER,
  MOVEMENT,
  AT,
  IS,
  ROOM,
  BAR,
};

enum { MAX_PARAMETERS = 120 }; // tree-sitter gives the state 1,024 bytes

typedef struct {
  uint32_t hash; // of the name
  uint32_t symbol; // NUMBER or MOVEMENT
} Parameter;

typedef struct {
  uint32_t open_brackets;
  uint32_t next_line; // END or LINE_BREAK for blank lines and comments, whose line ends are already decided; or UNKNOWN
  uint32_t parameter_count;
  Parameter parameters[MAX_PARAMETERS];
} Scanner;

enum { UNKNOWN = 0xFF };

// The next character; ours, if it stands for one of ours (improv_core/syntax/characters.py).
static int32_t next_of(const TSLexer *lexer) {
  int32_t c = lexer->lookahead;
  if (c < 0xA0) return c;
  if (c == 0xA0 || c == 0xAD || c == 0x1680 || (0x2000 <= c && c <= 0x200B) || c == 0x202F || c == 0x205F) return ' ';
  if (c == 0x3000 || (0x2060 <= c && c <= 0x2064)) return ' ';
  if (c == 0x2212) return '-';
  if (c == 0xD7) return '*';
  if (c == 0xF7 || c == 0x2044) return '/';
  int32_t narrow = c - 0xFEE0;
  bool is_latin = ('a' <= narrow && narrow <= 'z') || ('A' <= narrow && narrow <= 'Z');
  return '!' <= narrow && narrow <= '~' && !is_latin ? narrow : c;
}

static bool is_blank(int32_t c) { return c == ' ' || c == '\t' || c == 0xFEFF; }

static bool is_line_end(int32_t c) { return c == '\n' || c == '\r'; }

static bool is_digit(int32_t c) { return '0' <= c && c <= '9'; }

// Beyond ASCII, all but spaces and general punctuation are letters: iswalpha() knows none of them in the C locale.
// Joiners stand within words.
static bool is_letter(int32_t c) {
  if (c < 0x80) return ('a' <= c && c <= 'z') || ('A' <= c && c <= 'Z') || c == '_';
  return c >= 0xAA && c != 0xFEFF && (!(0x2000 <= c && c < 0x2070) || c == 0x200C || c == 0x200D);
}

static void look_past_blanks(TSLexer *lexer) {
  while (is_blank(next_of(lexer))) lexer->advance(lexer, false);
}

static void skip_line_end(TSLexer *lexer) {
  bool is_carriage_return = next_of(lexer) == '\r';
  lexer->advance(lexer, false);
  if (is_carriage_return && next_of(lexer) == '\n') lexer->advance(lexer, false);
}

static void look_past_comments(TSLexer *lexer) {
  while (!lexer->eof(lexer)) {
    if (next_of(lexer) == '#') {
      while (!lexer->eof(lexer) && !is_line_end(next_of(lexer))) lexer->advance(lexer, false);
    } else if (is_blank(next_of(lexer)) || is_line_end(next_of(lexer))) {
      lexer->advance(lexer, false);
    } else {
      return;
    }
  }
}

static bool takes(TSLexer *lexer, int32_t sign) {
  if (next_of(lexer) != sign) return false;
  lexer->advance(lexer, false);
  return true;
}

// The hash (FNV-1a) of the name that follows; 0 if none does.
static uint32_t take_name(TSLexer *lexer) {
  if (!is_letter(next_of(lexer))) return 0;
  uint32_t hash = 2166136261;
  while (is_letter(next_of(lexer)) || is_digit(next_of(lexer))) {
    hash = (hash ^ (uint32_t)next_of(lexer)) * 16777619;
    lexer->advance(lexer, false);
  }
  return hash ? hash : 1;
}

static uint32_t hash_of(const char *word) {
  uint32_t hash = 2166136261;
  while (*word) hash = (hash ^ (uint32_t)*word++) * 16777619;
  return hash;
}

// One parameter that is a movement: `(m)`.
static bool take_movement(TSLexer *lexer) {
  if (!takes(lexer, '(')) return false;
  look_past_blanks(lexer);
  if (!take_name(lexer)) return false;
  look_past_blanks(lexer);
  return takes(lexer, ')');
}

// Whether the line continues a statement: it begins with `||` or `else`. And whether it begins like one, which matters
// inside brackets: `beat NUMBER`, `---`, `NAME … =` with parameters, or `NAME … $`.
static void look_at_line(TSLexer *lexer, bool *continues, bool *begins) {
  *continues = *begins = false;
  if (takes(lexer, '|')) *continues = next_of(lexer) == '|';
  if (takes(lexer, '-')) *begins = takes(lexer, '-') && next_of(lexer) == '-';
  uint32_t word = take_name(lexer);
  if (!word) return;
  *continues = word == hash_of("else");
  bool is_beat = word == hash_of("beat") && is_blank(next_of(lexer));
  bool may_define = true, may_play = true, after_blank = false;
  while (may_define || may_play) {
    int32_t next = next_of(lexer);
    if (is_beat && !is_blank(next)) {
      *begins = is_digit(next) || next == '-' || next == '+' || next == '.';
      if (*begins) return;
      is_beat = false;
    }
    if (next == '=' || next == '$') {
      *begins = next == '=' ? may_define : may_play;
      return;
    }
    if (lexer->eof(lexer) || is_line_end(next) || next == '#' || next == '|' || next == ')') return;
    if (next == '(' || next == '[') {
      may_play = false;
      may_define = may_define && take_movement(lexer);
    } else if (is_letter(next)) {
      may_define = may_define && after_blank;
      take_name(lexer);
    } else {
      may_define = may_define && is_blank(next);
      lexer->advance(lexer, false);
    }
    after_blank = is_blank(next);
  }
}

// Line ends between comments follow from the one before them, so that a long comment is read once, not once per line.
static void scan_line_end(Scanner *scanner, TSLexer *lexer) {
  skip_line_end(lexer);
  lexer->mark_end(lexer);
  look_past_blanks(lexer);
  bool code_follows = next_of(lexer) != '#' && !is_line_end(next_of(lexer));
  uint32_t symbol = scanner->next_line;
  if (symbol == UNKNOWN) {
    bool continues, begins;
    look_past_comments(lexer);
    look_at_line(lexer, &continues, &begins);
    symbol = (scanner->open_brackets ? !begins : continues) ? LINE_BREAK : END;
  }
  if (symbol == END) scanner->open_brackets = scanner->parameter_count = 0;
  scanner->next_line = code_follows ? UNKNOWN : symbol;
  lexer->result_symbol = (TSSymbol)symbol;
}

static void add_parameter(Scanner *scanner, uint32_t hash, uint32_t symbol) {
  if (scanner->parameter_count < MAX_PARAMETERS) {
    scanner->parameters[scanner->parameter_count++] = (Parameter){hash, symbol};
  }
}

static bool is_code_left(TSLexer *lexer) {
  return !lexer->eof(lexer) && !is_line_end(next_of(lexer)) && next_of(lexer) != '#';
}

// The hash of a name of a profile, which may have `-` within; 0 if none follows.
static uint32_t take_profile(TSLexer *lexer) {
  uint32_t hash = take_name(lexer);
  while (hash && next_of(lexer) == '-') {
    while (takes(lexer, '-')) {
    }
    hash = is_letter(next_of(lexer)) || is_digit(next_of(lexer));
    while (is_letter(next_of(lexer)) || is_digit(next_of(lexer))) lexer->advance(lexer, false);
  }
  return hash;
}

// Whether what is left of the line is neither that of a definition or a play nor a robot's kind: `at circle is puppet`.
static bool stays_a_place(TSLexer *lexer, uint32_t last) {
  uint32_t before_last = 0;
  bool has_only_names = last != 0;
  while (is_code_left(lexer)) {
    if (next_of(lexer) == '=' || next_of(lexer) == '$') return false;
    if (is_letter(next_of(lexer))) {
      before_last = last;
      last = take_profile(lexer);
    } else {
      has_only_names = has_only_names && is_blank(next_of(lexer));
      lexer->advance(lexer, false);
    }
  }
  return !(has_only_names && last && before_last == hash_of("is"));
}

static bool begins_number(int32_t c) { return is_digit(c) || c == '.' || c == '+' || c == '-'; }

// The word of the opening that a name may be here, as what follows it suggests; or DEFINED.
static uint32_t opening_word(uint32_t name, int32_t next, const bool *valid_symbols) {
  if (valid_symbols[AT] && name == hash_of("at") && (begins_number(next) || is_letter(next))) return AT;
  if (valid_symbols[IS] && name == hash_of("is") && is_letter(next)) return IS;
  if (valid_symbols[ROOM] && name == hash_of("room") && begins_number(next)) return ROOM;
  if (valid_symbols[BAR] && name == hash_of("bar") && begins_number(next)) return BAR;
  return DEFINED;
}

// Whether it is that word, as the rest of its line decides.
static bool scan_opening(TSLexer *lexer, uint32_t word) {
  lexer->result_symbol = (TSSymbol)word;
  if (word == IS) {
    if (!take_profile(lexer)) return false;
    look_past_blanks(lexer);
    return !is_code_left(lexer);
  }
  if (begins_number(next_of(lexer))) return stays_a_place(lexer, 0);
  uint32_t formation = take_name(lexer);
  bool is_formation = formation == hash_of("circle") || formation == hash_of("line") || formation == hash_of("grid");
  return is_formation && stays_a_place(lexer, formation);
}

// The rest of a definition's head, up to `=`: names of numbers, then names of movements in parentheses.
static bool scan_head(Scanner *scanner, TSLexer *lexer) {
  uint32_t name;
  look_past_blanks(lexer);
  while ((name = take_name(lexer))) {
    add_parameter(scanner, name, NUMBER);
    look_past_blanks(lexer);
  }
  while (takes(lexer, '(')) {
    look_past_comments(lexer);
    if (!(name = take_name(lexer))) break;
    add_parameter(scanner, name, MOVEMENT);
    look_past_comments(lexer);
    if (!takes(lexer, ')')) break;
    look_past_blanks(lexer);
  }
  if (next_of(lexer) == '=') return true;
  scanner->parameter_count = 0;
  return false;
}

static bool scan_name(Scanner *scanner, TSLexer *lexer, const bool *valid_symbols) {
  uint32_t name = take_name(lexer);
  lexer->mark_end(lexer);
  for (uint32_t i = 0; i < scanner->parameter_count; i++) {
    Parameter parameter = scanner->parameters[i];
    if (parameter.hash == name) {
      lexer->result_symbol = (TSSymbol)parameter.symbol;
      return valid_symbols[parameter.symbol];
    }
  }
  look_past_blanks(lexer);
  uint32_t word = opening_word(name, next_of(lexer), valid_symbols);
  if (word != DEFINED) return scan_opening(lexer, word);
  lexer->result_symbol = DEFINED;
  return valid_symbols[DEFINED] && !scanner->parameter_count && scan_head(scanner, lexer);
}

// Takes every line end and bracket, even where the grammar does not expect it, so that an error stays in its statement.
bool tree_sitter_improv_external_scanner_scan(void *payload, TSLexer *lexer, const bool *valid_symbols) {
  Scanner *scanner = payload;
  while (is_blank(next_of(lexer))) lexer->advance(lexer, true); // they are no part of the token
  int32_t next = next_of(lexer);

  if (is_line_end(next)) {
    scan_line_end(scanner, lexer);
    return true;
  }
  if (is_letter(next)) return scan_name(scanner, lexer, valid_symbols);

  if (next == '(' || next == '[') {
    ++scanner->open_brackets;
    lexer->result_symbol = next == '(' ? OPEN_GROUP : OPEN_SQUEEZE;
  } else if (next == ')' || next == ']') {
    if (scanner->open_brackets) --scanner->open_brackets;
    lexer->result_symbol = next == ')' ? CLOSE_GROUP : CLOSE_SQUEEZE;
  } else {
    return false;
  }
  lexer->advance(lexer, false);
  return true;
}

void *tree_sitter_improv_external_scanner_create(void) {
  Scanner *scanner = ts_calloc(1, sizeof(Scanner));
  scanner->next_line = UNKNOWN;
  return scanner;
}

void tree_sitter_improv_external_scanner_destroy(void *payload) { ts_free(payload); }

unsigned tree_sitter_improv_external_scanner_serialize(void *payload, char *buffer) {
  Scanner *scanner = payload;
  unsigned length = offsetof(Scanner, parameters) + scanner->parameter_count * sizeof(Parameter);
  memcpy(buffer, scanner, length);
  return length;
}

void tree_sitter_improv_external_scanner_deserialize(void *payload, const char *buffer, unsigned length) {
  Scanner *scanner = payload;
  scanner->open_brackets = scanner->parameter_count = 0;
  scanner->next_line = UNKNOWN;
  if (length) memcpy(scanner, buffer, length);
}
