:- module(facetlog_small_terms, [ must_be_small/1,     % +Term
                                  small_key/1,         % +Term
                                  shortened/2          % +Term, -Short
                                ]).

/** <module> Terms that C can follow

SWI-Prolog compiles and writes terms by recursion in C, each part as often as it is shared. Where no
signal handler watches C's stack, as in Python, a deep term would end the process, and one of forty
levels that shares its parts would take all memory.
*/

:- use_module(library(apply)).
:- use_module(library(error)).
:- use_module(library(lists)).

%   A level takes less than 1 KB of C's stack (measured by reading nested terms: 2 MB hold 2,000).
deepest(1_000).

%   Parts of a term, shared ones counted as often as they occur; a proof of many faces has hundreds.
largest(100_000).

%!  must_be_small(+Term) is det.
%
%   @error resource_error(term_size) if Term is too deep or too large to be compiled.

must_be_small(Term) :-
    deepest(Depth),
    largest(Most),
    (   counted(Term, Depth, Most, _)
    ->  true
    ;   resource_error(term_size)
    ).

%   Of a key that is remembered beside its answer; a test of a model has some ten parts.
largest_key(1_000).

%!  small_key(+Term) is semidet.
%
%   Term is small enough to be remembered as often as answers are.

small_key(Term) :-
    deepest(Depth),
    largest_key(Most),
    counted(Term, Depth, Most, _).

%   Left is what of Most is left. A long list is long, not deep; strings and long numbers count as
%   many parts as they take cells.
counted(Term, _, Most, Left) :-
    \+ compound(Term),
    !,
    term_size(Term, Cells),
    Left is Most - 1 - Cells,
    Left >= 0.
counted([Head|Tail], Depth, Most, Left) :-
    !,
    Depth > 0,
    Less is Depth - 1,
    counted(Head, Less, Most, Left0),
    counted(Tail, Depth, Left0, Left).
counted(Term, Depth, Most, Left) :-
    Depth > 0,
    Most > 0,
    Less is Depth - 1,
    One is Most - 1,
    compound_name_arguments(Term, _, Args),
    foldl(counted_part(Less), Args, One, Left).

counted_part(Depth, Part, Most, Left) :-
    counted(Part, Depth, Most, Left).

%   What of a term a message shows.
shown_levels(6).
shown_parts(10).

%!  shortened(+Term, -Short) is det.
%
%   Short is Term with ... for what lies too deep or is too much for a message.

shortened(Term, Short) :-
    shown_levels(Levels),
    shortened(Term, Levels, Short).

shortened(Term, _, Short) :-
    \+ compound(Term),
    !,
    (   ( atom(Term) ; string(Term) ),
        atom_length(Term, Length),
        Length > 500
    ->  sub_atom(Term, 0, 500, _, Begin),
        atom_concat(Begin, '...', Short)
    ;   Short = Term
    ).
shortened(_, 0, '...') :- !.
shortened([Head|Tail], Levels, Short) :-
    !,
    shown_parts(Most),
    Less is Levels - 1,
    shortened_list([Head|Tail], Most, Less, Short).
shortened(Term, Levels, Short) :-
    shown_parts(Most),
    Less is Levels - 1,
    compound_name_arity(Term, Name, Arity),
    (   Arity =< Most
    ->  compound_name_arguments(Term, Name, Args),
        maplist(shortened_part(Less), Args, Shorts),
        compound_name_arguments(Short, Name, Shorts)
    ;   Short = '...'
    ).

shortened_part(Levels, Term, Short) :-
    shortened(Term, Levels, Short).

shortened_list(List, 0, _, ['...']) :-
    nonvar(List),
    List = [_|_],
    !.
shortened_list(List, Most, Levels, Short) :-
    nonvar(List),
    List = [Head|Tail],
    !,
    Less is Most - 1,
    Short = [ShortHead|ShortTail],
    shortened(Head, Levels, ShortHead),
    shortened_list(Tail, Less, Levels, ShortTail).
shortened_list(Tail, _, Levels, Short) :-
    shortened(Tail, Levels, Short).
