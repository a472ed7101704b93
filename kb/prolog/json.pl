:- module(facetlog_json, [ json/2,             % +Term, -Text
                           json_reply/2,       % +Parts, -Text
                           name_variables/1    % ?Term
                         ]).

/** <module> Any term as JSON

  - a number: an integer of any size or a finite float;
  - {"a": Text}: an atom; {"s": Text}: a string; {"v": Name}: a variable;
    {"r": ["1", "3"]}: a rational; {"i": "-ff"}: a long integer; {"n": "inf"}: a float that JSON lacks; {"x": Text}: other atomics;
  - [...]: a proper list;
  - {"f": Name, "t": [...]}: a compound.

Control characters are escaped, all others written as they are.
*/

:- use_module(library(apply)).
:- use_module(library(error)).
:- use_module(library(lists)).

%!  json(+Term, -Text) is det.
%
%   Variables are named in the order in which they occur, so that equal terms give equal text.
%
%   @error domain_error(acyclic_term, _) for a cyclic term.

json(Term, Text) :-
    with_output_to(string(Text),
                   \+ \+ ( name_variables(Term),
                           json(Term) )).

%!  json_reply(+Parts, -Text) is det.
%
%   A list of text(String), a bare JSON string, and term(Term).
%
%   @error domain_error(acyclic_term, _) for a cyclic term.

json_reply(Parts, Text) :-
    with_output_to(string(Text),
                   \+ \+ ( name_variables(Parts),
                           write('['),
                           reply_parts(Parts),
                           write(']') )).

reply_parts([]).
reply_parts([Part]) :-
    !,
    reply_part(Part).
reply_parts([Part|Parts]) :-
    reply_part(Part),
    write(','),
    reply_parts(Parts).

reply_part(text(Text)) :- quoted(Text).
reply_part(term(Term)) :- json(Term).

:- dynamic variable_mark/1.             % Mark

%   The name of what variables are bound to: a blob, which no text and no goal can make.
:- mutex_create(Mark),
   retractall(variable_mark(_)),
   asserta(variable_mark(Mark)).

%!  name_variables(?Term) is det.
%
%   Binds the variables of Term to what json/2 writes as variables, in order of appearance.
%
%   @error domain_error(acyclic_term, _) for a cyclic term.

name_variables(Term) :-
    (   acyclic_term(Term)
    ->  true
    ;   domain_error(acyclic_term, cyclic)
    ),
    (   ground(Term)
    ->  true
    ;   term_attvars(Term, Attributed),
        maplist(del_attrs, Attributed),
        variable_mark(Mark),
        numbervars(Term, 0, _, [functor_name(Mark)])
    ).

json(X) :-
    compound(X),
    compound_name_arity(X, Mark, 1),
    variable_mark(Mark),
    !,
    arg(1, X, N),
    format(atom(Name), "X~d", [N]),
    tagged("v", Name).
json(X) :- integer(X), !, json_integer(X).
json(X) :- float(X), !, json_float(X).
json(X) :- rational(X, N, D), !, format("{\"r\":[\"~16r\",\"~16r\"]}", [N, D]).
json(X) :- X == [], !, write([]).
json(X) :- atom(X), !, tagged("a", X).
json(X) :- string(X), !, tagged("s", X).
json(X) :- atomic(X), !, format(string(Text), "~w", [X]), tagged("x", Text).
json(X) :- is_list(X), !, write('['), json_items(X), write(']').
json(X) :-
    compound_name_arguments(X, Name0, Args),
    name_text(Name0, Name),
    write('{"f":'), quoted(Name),
    write(',"t":['), json_items(Args), write(']}').

%   Python reads long decimals slowly, and beyond some thousands of digits not at all.
json_integer(X) :-
    (   abs(X) < 1 << 4096
    ->  write(X)
    ;   format("{\"i\":\"~16r\"}", [X])
    ).

json_float(X) :-
    (   float_class(X, Class),
        memberchk(Class, [infinite, nan])
    ->  ( Class == nan -> Name = nan ; X > 0 -> Name = inf ; Name = '-inf' ),
        format("{\"n\":\"~w\"}", [Name])
    ;   write(X)
    ).

%   The empty list may be a name too, but is no text.
name_text([], "[]") :- !.
name_text(Name, Name).

json_items([]).
json_items([X|Xs]) :-
    json(X),
    json_more(Xs).

json_more([]).
json_more([X|Xs]) :-
    write(','),
    json(X),
    json_more(Xs).

tagged(Tag, X) :-
    write('{"'),
    write(Tag),
    write('":'),
    quoted(X),
    write('}').

%   Most texts hold nothing that must be escaped: split_string/4 looks for it in C. To it NUL is in
%   every set: it ends a part, and is taken away at either end, which the lengths tell.
quoted(Text) :-
    put_char('"'),
    must_escape(Some),
    (   split_string(Text, Some, "", [Same]),
        string_length(Same, Length),
        string_length(Text, Length)
    ->  write(Text)
    ;   string_codes(Text, Codes),
        maplist(put_escaped, Codes)
    ),
    put_char('"').

:- dynamic must_escape/1.               % quotation mark, backslash and the control characters

:- numlist(1, 31, Controls),
   string_codes(Some, [0'", 0'\\|Controls]),
   retractall(must_escape(_)),
   asserta(must_escape(Some)).

put_escaped(0'") :- !, write('\\"').
put_escaped(0'\\) :- !, write('\\\\').
put_escaped(Code) :- Code >= 32, !, put_code(Code).
put_escaped(Code) :- format("\\u~|~`0t~16r~4+", [Code]).
