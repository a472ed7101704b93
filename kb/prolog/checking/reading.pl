:- module(facetlog_reading, [ read_question/4       % +Text, -Goal, -Position, -Names
                            ]).

/** <module> Text into terms with positions

Text of strangers is read as data. Nothing is expanded, no operator is declared, no flag changes,
no file is opened, and whatever is no plain term is a fault. A fault is

    fault(Start, End, Format, Args)

with character offsets into the text, counted from 0. Positions are those of read_term/2.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(facetlog_kb(positions)).
:- use_module(facetlog_kb(foreign_signs)).

%   Text is read in an empty module, whose operators come from the system alone, whatever the
%   program declares.
:- set_module(facetlog_text:class(library)),
   delete_import_module(facetlog_text, user),
   add_import_module(facetlog_text, system, start).

%   Words of directives are no operators: table is a model.
:- forall(( current_op(_, fx, Word),
            memberchk(Word, [table, dynamic, discontiguous, initialization, meta_predicate,
                             module_transparent, multifile, public, thread_local, thread_initialization,
                             volatile]) ),
          op(0, fx, facetlog_text:Word)).

%!  limit_of(?What, ?Number) is nondet.
%
%   SWI-Prolog 9.0.4 reads a number of n digits in a time that grows with n^2 and cannot be
%   interrupted meanwhile: 1.0 s at 200,000 digits, 24 s at 1,000,000. It reads nested terms by
%   recursion in C, with up to 1 KB of stack for a level, and in Python nothing saves the process
%   when that stack ends: Prolog's threads have 8 MB (engine_pool.py).

limit_of(question,  20_000).    % characters
limit_of(brackets,   5_000).    % opening ones, wherever they stand
limit_of(depth,      1_000).    % levels of a term

%   A byte order mark is no part of the text, and takes the place of one blank.
without_mark(Text, Plain) :-
    (   string_concat("\uFEFF", Rest, Text)
    ->  string_concat(" ", Rest, Plain)
    ;   Plain = Text
    ).

%   The end is read as end_of_file, which may also be written: then it stands in the text.
at_the_end(Term, Position, Text) :-
    Term == end_of_file,
    span(Position, _, End),
    string_length(Text, Length),
    End > Length.

%!  read_question(+Text, -Goal, -Position, -Names) is det.
%
%   Text is one term, with or without a full stop. Names are Name=Var in order of appearance.
%
%   @throws question_error(Start, End, Format, Args)

read_question(Text, Goal, Position, Names) :-
    ( text_fault(Text, Fault) -> faulty(Fault) ; true ),
    without_mark(Text, Plain),
    string_length(Plain, Length),
    string_concat(Plain, "\n.\n", Ended),
    setup_call_cleanup(
        open_string(Ended, Stream),
        ( read_one(Stream, Goal, Position, Names, Fault1),
          character_count(Stream, Read) ),
        close(Stream)),
    (   blank(Plain)
    ->  faulty(fault(0, Length, "the question is empty", []))
    ;   nonvar(Fault1)
    ->  (   foreign_sign(Plain, Fault2)
        ->  true
        ;   clipped(Fault1, Plain, Fault2)
        ),
        faulty(Fault2)
    ;   Read < Length,
        sub_string(Plain, Read, _, 0, Rest),
        \+ blank(Rest)
    ->  faulty(fault(Read, Length,
                     "a question is one goal: join goals by a comma, or ask them one by one", []))
    ;   span(Position, _, End),
        End > Length
    ->  faulty(fault(Length, Length, "the question ends too early", []))
    ;   unusable(Goal, Position, Fault3)
    ->  faulty(Fault3)
    ;   true
    ).

faulty(fault(Start, End, Format, Args)) :-
    throw(question_error(Start, End, Format, Args)).

%   Nothing but layout and comments.
blank(Text) :-
    setup_call_cleanup(
        open_string(Text, Stream),
        read_one(Stream, Term, Position, _, Fault),
        close(Stream)),
    var(Fault),
    at_the_end(Term, Position, Text).

                 /*******************************
                 *           THE READER         *
                 *******************************/

read_one(Stream, Term, Position, Names, Fault) :-
    catch(read_term(Stream, Term,
                    [ module(facetlog_text), syntax_errors(error),
                      subterm_positions(Position), variable_names(Names),
                      quasi_quotations(Quotations),
                      double_quotes(string), back_quotes(codes),
                      cycles(false), dotlists(false), var_prefix(false) ]),
          Error,
          reader_fault(Error, Fault)),
    (   nonvar(Quotations),
        Quotations = [_|_]
    ->  span(Position, Start, End),
        Fault = fault(Start, End, "quasi quotations {|...|} are not read", [])
    ;   true
    ).

reader_fault(error(syntax_error(Why), Where), fault(At, At, "syntax error: ~w", [What])) :-
    !,
    (   Why = end_of_file_in_quoted(Quote)
    ->  At = last(Quote)
    ;   Why == end_of_file_in_block_comment
    ->  At = last("/*")
    ;   Where = stream(_, _, _, At)
    ->  true
    ;   At = 0
    ),
    plain_words(Why, What).
reader_fault(error(resource_error(_), _), fault(0, 0, "this is too deep or too long", [])) :- !.
reader_fault(error(_, _), fault(0, 0, "this cannot be read", [])).

plain_words(Why, What) :-
    (   said_plainly(Why, What)
    ->  true
    ;   Why = undefined_char_escape(Char)
    ->  format(string(What), "\\~w is no escape of Prolog", [Char])
    ;   '$messages':syntax_error(Why, Parts, [])
    ->  with_output_to(string(What0), print_message_lines(current_output, '', Parts)),
        normalize_space(string(What), What0)
    ;   format(string(What), "~q", [Why])
    ).

said_plainly(operator_expected,    "a comma, an operator or a full stop is missing here").
said_plainly(operator_clash,       "these operators cannot stand side by side: use parentheses").
said_plainly(operator_balance,     "an operator lacks an argument").
said_plainly(end_of_clause,        "something is missing here, or not closed").
said_plainly(end_of_clause_expected, "a full stop is missing here").
said_plainly(end_of_file,          "the text ends within a clause: is a full stop missing?").
said_plainly(end_of_file_in_quoted(_),        "a quotation is not closed").
said_plainly(end_of_file_in_block_comment,    "a comment /* is not closed").
said_plainly(quoted_punctuation,   "something is missing before this sign").
said_plainly(list_rest,            "after the bar of a list one term must follow").
said_plainly(cannot_start_term,    "no term can begin with this").
said_plainly(illegal_number,       "this is no number").
said_plainly('Illegal character code', "this is no character").

%   An error is put where it is in the text, after what was read before, on what can be seen. One
%   that is nowhere in it is at its end.
clipped(fault(last(Sign), _, Format, Args), Text, fault(Start, End, Format, Args)) :-
    !,
    % What is not closed was opened last.
    findall(At, sub_string(Text, At, _, _, Sign), Places),
    last([0|Places], Start),
    string_length(Text, End).
clipped(fault(Start0, End0, Format0, Args0), Text, fault(Start, End, Format, Args)) :-
    string_length(Text, Length),
    (   next_visible(Text, Length, Start0, Start)
    ->  End is max(Start + 1, min(End0, Length)),
        Format = Format0,
        Args = Args0
    ;   visible_end(Text, Length, Start),
        End = Start,
        ends_early(Args0, Format0-Args0, Format-Args)
    ).

next_visible(Text, Length, From, At) :-
    From < Length,
    sub_string(Text, From, 1, _, Char),
    (   char_type(Char, space)
    ->  Next is From + 1,
        next_visible(Text, Length, Next, At)
    ;   At = From
    ).

visible_end(Text, From, End) :-
    (   Before is From - 1,
        Before >= 0,
        sub_string(Text, Before, 1, _, Char),
        char_type(Char, space)
    ->  visible_end(Text, Before, End)
    ;   End = From
    ).

ends_early([What], Format-_, Format-["the text ends too early: something is missing"]) :-
    said_plainly(operator_expected, What),
    !.
ends_early(_, Fault, Fault).

character_count(Stream, Count) :-
    stream_property(Stream, position(Position)),
    stream_position_data(char_count, Position, Count).

                 /*******************************
                 *      WHAT IS NOT READ        *
                 *******************************/

text_fault(Text, fault(Limit, Length, "the question is too long: ~D characters, at most ~D are read",
                       [Length, Limit])) :-
    limit_of(question, Limit),
    string_length(Text, Length),
    Length > Limit,
    !.
text_fault(Text, fault(Offset, End, Format, Args)) :-
    string_codes(Text, Codes),
    (   hidden_code(Codes, Offset, Format, Args)
    ;   too_many_brackets(Codes, Offset, Format, Args)
    ),
    !,
    End is Offset + 1.

hidden_code(Codes, Offset, Format, [Code]) :-
    nth0(Offset, Codes, Code),
    hidden(Code, Format),
    !.

too_many_brackets(Codes, Offset, "too many brackets: at most ~D are read of one text", [Most]) :-
    limit_of(brackets, Most),
    findall(At, ( nth0(At, Codes, Code), memberchk(Code, `([{`) ), Brackets),
    nth0(Most, Brackets, Offset).

%   Characters that a reader of the text does not see, or sees elsewhere than they are.
hidden(Code, "a control character (code ~d) may not stand here") :-
    (   Code < 32
    ->  \+ memberchk(Code, [9, 10, 11, 12, 13])
    ;   Code >= 127,
        Code < 160,
        Code =\= 0x85
    ).
hidden(Code, "a character that turns the direction of writing (code ~d) may not stand here") :-
    (   between(0x202A, 0x202E, Code)
    ;   between(0x2066, 0x2069, Code)
    ;   memberchk(Code, [0x200E, 0x200F, 0x061C])
    ).
hidden(Code, "half a character (code ~d) may not stand here") :-
    between(0xD800, 0xDFFF, Code).

%!  unusable(+Term, +Position, -Fault) is semidet.
%
%   Term is more than a plain term.

unusable(Term, Position, fault(Start, End, Format, Args)) :-
    limit_of(depth, Depth),
    odd_part(Term, Position, Depth, Found, Format, Args),
    !,
    span(Found, Start, End).

odd_part(Term, Position, 0, Position, "this is nested too deeply: more than ~D levels", [Depth]) :-
    compound(Term),
    !,
    limit_of(depth, Depth).
odd_part(Term, Position, _, Position, "dicts are not read", []) :-
    is_dict(Term),
    !.
odd_part(Term, Position, Depth, Found, Format, Args) :-
    compound(Term),
    compound_name_arity(Term, Name, Arity),
    (   Name == '.',
        Arity =:= 2
    ->  Found = Position,
        Format = "a dot stands where none belongs: is a blank missing after a full stop?",
        Args = []
    ;   between(1, Arity, Index),
        arg(Index, Term, Part),
        compound(Part),
        argument_position(Position, Index, PartPosition),
        deeper(Name, Arity, Index, Depth, Less),
        odd_part(Part, PartPosition, Less, Found, Format, Args)
    ).
odd_part(Term, Position, _, Position, "`end_of_file` ends no file: leave it out", []) :-
    Term == end_of_file.

%   A long list and a long conjunction are long, not deep: they are not compiled by recursion.
deeper(Name, 2, 2, Depth, Depth) :-
    memberchk(Name, [',', '[|]']),
    !.
deeper(_, _, _, Depth, Less) :-
    Less is Depth - 1.
