:- module(facetlog_pairs, [ each_pair_in/5      % +Module, -X, -Y, ?Faces, +Test
                          ]).

/** <module> Faces of which each two pass a test

Which two faces pass is worked out once for a scene and remembered with it: for each face the later
ones that it may stand with, as the bits of an integer. To choose faces one after the other is then
to intersect integers, so that the three square faces of a box are found without asking any angle
again.
*/

:- use_module(library(lists)).
:- use_module(library(error)).
:- use_module(library(occurs)).
:- use_module(facetlog_kb(small_terms)).
:- use_module(facetlog_kb(scene)).
:- use_module(facetlog_kb(say)).
:- use_module(facetlog_kb(compare)).
:- use_module(facetlog_kb(quantities)).
:- use_module(facetlog_kb(recall)).
:- use_module(facetlog(vocabulary)).
:- use_module(facetlog(measures)).

:- set_prolog_flag(optimise, true).

%!  each_pair_in(+Module, -X, -Y, ?Faces, +Test) is nondet.
%
%   Faces is a list of measured faces of the current scene, in the order of terms, and Test holds of
%   each two of them. X and Y stand for the two in Test; words and tolerances are those of Module.
%   A list of a given length is filled in all ways. But for the time that takes it is
%
%     ==
%     each_pair_in(Module, X, Y, Faces, Test) :-
%         findall(F, ( fact(face(F)), fact(evidence(F, measured)) ), All0),
%         sort(All0, All),
%         in_order(Faces, All),           % some of All, in their order
%         state(each_pair(X, Y, Faces, Test), Module, holds).
%     ==

each_pair_in(Module, X, Y, Faces, Test) :-
    must_be(list, Faces),
    must_be(var, X),
    must_be(var, Y),
    known_graph(Module, X, Y, Test, graph(Names, Later)),
    compound_name_arity(Names, _, Count),
    All is (1 << (Count + 1)) - 2,
    chosen(Faces, All, Names, Later).

known_graph(Module, X, Y, Test, Graph) :-
    must_be_small(Test),
    (   mentions_number(Test)
    ->  graph(Module, X, Y, Test, Graph)
    ;   copy_term(X-Y-Test, Key),
        numbervars(Key, 0, _),
        recall(Module, pairs, pairs, Key, Graph, graph(Module, X, Y, Test, Graph))
    ).

%   Its key would be taken for that of a test with a variable there.
mentions_number(Test) :-
    compound(Test),
    sub_term(Part, Test),
    compound(Part),
    Part = '$VAR'(_),
    !.

chosen([], _, _, _).
chosen([Face|Faces], Candidates, Names, Later) :-
    bit(Candidates, Number),
    arg(Number, Names, Face),
    (   Faces == []
    ->  true
    ;   arg(Number, Later, Others),
        Rest is Candidates /\ Others,
        chosen(Faces, Rest, Names, Later)
    ).

bit(Bits, Number) :-
    Bits > 0,
    Lowest is lsb(Bits),
    Rest is Bits /\ (Bits - 1),
    (   Rest =:= 0
    ->  Number = Lowest
    ;   Number = Lowest
    ;   bit(Rest, Number)
    ).

                 /*******************************
                 *           THE GRAPH          *
                 *******************************/

%   Names are the faces in order, Later has for each the numbers of those that pass with it.
graph(Module, X, Y, Test, graph(Names, Later)) :-
    findall(Face, ( fact(face(Face)), fact(evidence(Face, measured)) ), Faces0),
    sort(Faces0, Faces),
    compound_name_arguments(Names, faces, Faces),
    findall(Face-Number, nth1(Number, Faces, Face), Numbered),
    dict_pairs(Numbers, numbers, Numbered),
    search(Test, Module, X, Y, Faces, Search),
    findall(A-B,
            ( call(Search),
              get_dict(X, Numbers, A),
              get_dict(Y, Numbers, B) ),
            Pairs0),
    sort(Pairs0, Pairs),
    length(Faces, Count),
    later(1, Count, Pairs, Sets),
    compound_name_arguments(Later, later, Sets).

later(Number, Count, Pairs, Sets) :-
    (   Number > Count
    ->  Sets = []
    ;   bits(Pairs, Number, 0, Bits, Rest),
        Sets = [Bits|Sets1],
        Next is Number + 1,
        later(Next, Count, Rest, Sets1)
    ).

bits([Number-Other|Pairs], Number, Bits0, Bits, Rest) :-
    !,
    Bits1 is Bits0 \/ (1 << Other),
    bits(Pairs, Number, Bits1, Bits, Rest).
bits(Pairs, _, Bits, Bits, Pairs).

                 /*******************************
                 *         FINDING PAIRS        *
                 *******************************/

%   Search binds X and Y to things in order of which Test holds. What was not measured or not stated
%   does not hold, so most tests need to be asked only of pairs of which the scene has a fact; others
%   are tried on all pairs of faces.
search(Test, Module, X, Y, Faces, facetlog_pairs:Search) :-
    (   comparison(Test, Measure, Bounds),
        measure_of_both(Measure, X, Y)
    ->  Search = passing(Measure, Bounds, Module, Test, X, Y)
    ;   stated(Test, Module, X, Y, Proposal)
    ->  Search = ( Proposal, X @< Y, state(Test, Module, holds) )
    ;   Search = ( two(Faces, X, Y), state(Test, Module, holds) )
    ).

%   The measure's fact is at hand: looking it up again would cost an index and twice the time.
passing(Measure, Bounds, Module, Test, X, Y) :-
    measured(Measure, Bounds, X, Y, Value, Sd, Kind),
    variance(Sd, Var),
    passes(quantity(Value, Var, Kind), Measure, Bounds, Module, Test).

measured(Measure, Bounds, X, Y, Value, Sd, Kind) :-
    measure(Measure, Value, Sd, Kind),
    X @< Y,
    inside(Bounds, Value).

%   Value may be inside: what is cheap to see is seen first.
inside(near(Target, Tolerance), Value) :-
    number(Target), number(Tolerance),
    !,
    abs(Value - Target) =< Tolerance.
inside(at_least(Limit), Value) :- number(Limit), !, Value >= Limit.
inside(at_most(Limit), Value) :- number(Limit), !, Value =< Limit.
inside(between(Low, High), Value) :-
    number(Low), number(High),
    !,
    Value >= Low,
    Value =< High.
inside(_, _).

%   Proposal binds X and Y, in either order, to all of which Test may hold.
stated(Test, _, X, Y, measured(Measure, Bounds, X, Y, _, _, _)) :-
    comparison(Test, Measure, Bounds),
    !,
    measure_of_both(Measure, X, Y).
stated(all(Tests), Module, X, Y, Proposal) :-
    !,
    is_list(Tests),
    member(Test, Tests),
    stated(Test, Module, X, Y, Proposal),
    !.
stated(adjoins(A, B), _, X, Y, fact(adjoins(A, B, _))) :-
    !,
    of_both(adjoins(A, B), X, Y).
stated(Relation, _, X, Y, fact(Relation)) :-
    memberchk(Relation, [coplanar(_, _), opposite(_, _), convex(_, _), concave(_, _)]),
    !,
    of_both(Relation, X, Y).
stated(Word, Module, X, Y, Proposal) :-
    meaning(Word, Module, Meaning),
    stated(Meaning, Module, X, Y, Proposal).

measure_of_both(Measure, X, Y) :-
    of_both(Measure, X, Y),
    \+ \+ known_measure(Measure).

of_both(Term, X, Y) :-
    compound(Term),
    compound_name_arguments(Term, _, [A, B]),
    (   A == X, B == Y
    ->  true
    ;   A == Y, B == X
    ).

two([X|Faces], X, Y) :- member(Y, Faces).
two([_|Faces], X, Y) :- two(Faces, X, Y).
