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
:- use_module(facetlog_kb(recall)).

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
    findall(A-B,
            ( append(_, [X-A|Others], Numbered),
              member(Y-B, Others),
              state(Test, Module, holds) ),
            Pairs),
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
