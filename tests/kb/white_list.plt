% The list of harmless words against what Prolog says of them.
:- use_module(library(plunit)).
:- use_module(facetlog_kb(white_list)).
:- use_module(facetlog_kb(words)).
:- use_module(facetlog_kb(spelling)).

listed(Name/Arity, Head) :-
    allowed(Head, _),
    functor(Head, Name, Arity).

%   What Prolog says of the arguments: of the word itself or of its namesake in the system.
meta(Name/Arity, Spec) :-
    functor(General, Name, Arity),
    predicate_property(facetlog_query:General, meta_predicate(Spec)).

called(Sort) :- integer(Sort).
called(^).
called(//).

agree(0, goal(_)).
agree(0, inner(_)).
agree(^, bag(_)).
agree(Extra, closure(Extra, _)).

:- begin_tests(white_list).

test(every_word_is_there, all(Word == [])) :-
    listed(Word, _),
    Word = Name/Arity,
    functor(General, Name, Arity),
    \+ predicate_property(facetlog_query:General, defined).
test(no_word_is_listed_twice) :-
    findall(Word, listed(Word, _), Words),
    sort(Words, Set),
    length(Words, Length),
    assertion(length(Set, Length)).
test(every_argument_that_is_called_is_declared, all(Word-Index == [])) :-
    listed(Word, Head),
    meta(Word, Spec),
    arg(Index, Spec, Sort),
    called(Sort),
    arg(Index, Head, Declared),
    \+ agree(Sort, Declared).
test(every_argument_that_is_declared_is_called, all(Word-Index == [])) :-
    listed(Word, Head),
    compound(Head),
    Word \== (->)/2,
    Word \== (*->)/2,
    arg(Index, Head, Declared),
    agree(_, Declared),
    meta(Word, Spec),
    arg(Index, Spec, Sort),
    \+ agree(Sort, Declared).
test(no_word_of_the_vocabulary_calls_an_argument, all(Word-Sort == [])) :-
    module_property(vocabulary, exports(Words)),
    member(Word, Words),
    Word = Name/Arity,
    functor(General, Name, Arity),
    predicate_property(vocabulary:General, meta_predicate(Spec)),
    arg(_, Spec, Sort),
    called(Sort).
test(every_module_sensitive_word_of_the_vocabulary_is_told_its_module, all(Word == [])) :-
    % It would take a module from its argument: prepared/4 gives it one.
    module_property(vocabulary, exports(Words)),
    member(Word, Words),
    Word = Name/Arity,
    functor(General, Name, Arity),
    predicate_property(vocabulary:General, transparent),
    facetlog_prepare:prepared(General, t, some_module, Runnable),
    Runnable == General.
test(what_acts_is_not_listed, all(Word == [])) :-
    member(Word, [halt/0, halt/1, shell/1, open/3, open/4, consult/1, load_files/2, assertz/1,
                  asserta/1, assert/1, retract/1, retractall/1, abolish/1, erase/1, recorda/3,
                  nb_setval/2, b_setval/2, nb_getval/2, b_getval/2, flag/3, op/3, catch/3,
                  throw/1, setup_call_cleanup/3, call_cleanup/2, thread_create/3, thread_signal/2,
                  set_prolog_flag/2, create_prolog_flag/3, print_message/2, format/1, format/2,
                  format/3, write/1, print/1, read_term/2, read/1, term_to_atom/2, term_string/2,
                  atom_to_term/3, sformat/3, with_output_to/2, freeze/2, when/2, put_attr/3, dif/2,
                  tnot/1, abolish_all_tables/0, nb_setarg/3, setarg/3, prompt/2, see/1, tell/1,
                  getenv/2, setenv/2, unify_with/2, apply/2, (:)/2, (@)/2, (^)/2, (>>)/2, (=>)/2,
                  clause/2, current_predicate/1, current_op/3, current_prolog_flag/2,
                  garbage_collect/0, garbage_collect_atoms/0, use_foreign_library/1, module/1,
                  set_module/1, import_module/2, engine_create/3, sleep/1, trace/0, break/0]),
    ( listed(Word, _) ; search_word(Word) ).

:- end_tests(white_list).

:- begin_tests(spelling).

test(a_slip_is_seen, all(Name-Nearest == [angel-angle, levl-level, tlit-tilt, fase-face,
                                          findal-findall, fac_of-face_of])) :-
    member(Name, [angel, levl, tlit, fase, findal, fac_of]),
    nearest(Name, [angle, area, level, tilt, fill, face, findall, forall, face_of, of], Nearest).
test(another_word_is_no_slip, all(Name == [])) :-
    member(Name, [shell, x, open, b]),
    nearest(Name, [a, face, angle, level, is, of, (>>)], _).

:- end_tests(spelling).
