:- module(facetlog_joined_names, [ joined/4            % +Goal, +Position, -Place, -Constant
                                 ]).

/** <module> Which constants a question compares with an argument of a call

is_a(T, M), M = tabel asks no more than is_a(T, tabel). The variables of a question that =, ==, \=, \==,
member, maplist and their like join are one class, and a constant that is compared with one of them is
compared with all.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(library(assoc)).
:- use_module(library(pairs)).
:- use_module(facetlog_kb(positions)).

%!  joined(+Goal, +Position, -Place, -Constant) is nondet.
%
%   Constant, Term-At, is compared with the argument Place, place(Call, Index), of a call in Goal. Call is
%   ground: its variables are v(Number).

joined(Goal0, Position, Place, Constant) :-
    copy_term_nat(Goal0, Goal),
    term_variables(Goal, Variables),
    foldl([v(N), N, Next]>>( Next is N + 1 ), Variables, 1, Next),
    findall(Pair, joined_pair(Goal, Position, Pair), Pairs),
    Last is Next - 1,
    classes(Last, Pairs, Classes, Constants),
    standing(Goal, Position, Place, Term-At),
    (   class(Term, Classes, Class)
    ->  get_assoc(Class, Constants, Compared),
        member(Constant, Compared)
    ;   Constant = Term-At
    ).

%   Classes are classes(Of, OfElements), each with the class of each variable; Constants are what each class
%   is compared with.
classes(Count, Pairs, Classes, Constants) :-
    functor(Of, of, Count),
    functor(OfElements, of, Count),
    Classes = classes(Of, OfElements),
    maplist(join_classes(Classes), Pairs),
    numbervars(Classes, 0, _),
    findall(Class-Constant,
            ( member(A-B, Pairs),
              ( A = Variable-_, B = Constant ; B = Variable-_, A = Constant ),
              Constant = Term-_,
              \+ variable(Term),
              class(Variable, Classes, Class) ),
            Keyed0),
    sort(0, @=<, Keyed0, Keyed),
    group_pairs_by_key(Keyed, Grouped),
    list_to_assoc(Grouped, Constants).

join_classes(Classes, (A-_)-(B-_)) :-
    (   class(A, Classes, Class),
        class(B, Classes, Class)
    ->  (   A = v(_),                   % of the same lists the elements are the same
            B = v(_)
        ->  class(e(A), Classes, ClassOfElements),
            class(e(B), Classes, ClassOfElements)
        ;   true
        )
    ;   true
    ).

%   e(List) is any element of List.
class(v(Number), classes(Of, _), Class) :-
    arg(Number, Of, Class).
class(e(v(Number)), classes(_, OfElements), Class) :-
    arg(Number, OfElements, Class).

variable(Term) :-
    compound(Term),
    ( Term = v(_) ; Term = e(_) ),
    !.

%   A variable at its place, or what a word that goes through a list puts there.
standing(Goal, Position, place(Call, Index), v(Number)-At) :-
    part(Goal, Position, Call-At),
    arg(Index, Call, v(Number)).
standing(Goal, Position, place(Call, Index), Element) :-
    part(Goal, Position, Part-At),
    compound_name_arguments(Part, Word, [Closure|Lists]),
    memberchk(Word, [maplist, include, exclude, partition]),
    (   compound(Closure)
    ->  compound_name_arguments(Closure, Name, Arguments)
    ;   atom(Closure),
        Name = Closure,
        Arguments = []
    ),
    Name \== v,
    ( Word == maplist -> length(Lists, Missing) ; Missing = 1 ),
    length(More, Missing),
    maplist(=(missing), More),
    append(Arguments, More, All),
    Call =.. [Name|All],
    length(Arguments, Given),
    between(1, Missing, Nth),
    Index is Given + Nth,
    nth1(Nth, Lists, List),
    Place is Nth + 1,
    argument_position(At, Place, AtList),
    element(List, AtList, Element).

part(Term, Position, Term-Position) :-
    compound(Term),
    \+ variable(Term).
part(Term, Position, Part) :-
    compound(Term),
    \+ variable(Term),
    arg(Index, Term, Argument),
    compound(Argument),
    argument_position(Position, Index, At),
    part(Argument, At, Part).

%   Pair is (A-At)-(B-At), of two terms that some call in Goal compares.
joined_pair(Goal, Position, Pair) :-
    part(Goal, Position, Call-At),
    (   compared(Call, A, B),
        arg(A, Call, One),
        arg(B, Call, Other),
        argument_position(At, A, AtOne),
        argument_position(At, B, AtOther),
        corresponding(One-AtOne, Other-AtOther, Pair)
    ;   element_and_list(Call, A, B),
        arg(A, Call, One),
        arg(B, Call, List),
        argument_position(At, A, AtOne),
        argument_position(At, B, AtList),
        element(List, AtList, Element),
        corresponding(One-AtOne, Element, Pair)
    ).

compared(_ = _, 1, 2).
compared(_ == _, 1, 2).
compared(_ \= _, 1, 2).
compared(_ \== _, 1, 2).
compared(unify_with_occurs_check(_, _), 1, 2).

element_and_list(member(_, _), 1, 2).
element_and_list(memberchk(_, _), 1, 2).
element_and_list(select(_, _, _), 1, 2).
element_and_list(nth0(_, _, _), 3, 2).
element_and_list(nth1(_, _, _), 3, 2).
element_and_list(findall(_, _, _), 1, 3).
element_and_list(bagof(_, _, _), 1, 3).
element_and_list(setof(_, _, _), 1, 3).

element(v(Number), At, e(v(Number))-At).
element([First|Rest], At, Element) :-
    (   argument_position(At, 1, AtFirst),
        Element = First-AtFirst
    ;   argument_position(At, 2, AtRest),
        element(Rest, AtRest, Element)
    ).

corresponding(A-AtA, B-AtB, Pair) :-
    (   compound(A),
        compound(B),
        \+ variable(A),
        \+ variable(B)
    ->  functor(A, Name, Arity),
        functor(B, Name, Arity),
        arg(Index, A, PartA),
        arg(Index, B, PartB),
        argument_position(AtA, Index, AtPartA),
        argument_position(AtB, Index, AtPartB),
        corresponding(PartA-AtPartA, PartB-AtPartB, Pair)
    ;   Pair = (A-AtA)-(B-AtB)
    ).
