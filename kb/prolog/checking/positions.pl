:- module(facetlog_positions, [ span/3,               % +Position, -Start, -End
                                argument_position/3,  % +Position, +Index, -ArgumentPosition
                                name_position/2,      % +Position, -NamePosition
                                element_position/3,   % +Position, +Index, -ElementPosition
                                fault_at/4            % +Position, +Format, +Args, -Fault
                              ]).

/** <module> Where the parts of a term are in its text

Positions are those of read_term/2 (option subterm_positions), offsets are characters from 0.
*/

:- use_module(library(lists)).

%!  span(+Position, -Start, -End) is det.

span(Position, Start, End) :-
    arg(1, Position, Start),
    arg(2, Position, End).

%!  argument_position(+Position, +Index, -ArgumentPosition) is det.
%
%   Where the argument of that Index is; where the whole term is if the text does not show it.

argument_position(parentheses_term_position(_, _, Inner), Index, Position) :-
    !,
    argument_position(Inner, Index, Position).
argument_position(term_position(_, _, _, _, Positions), Index, Position) :-
    nth1(Index, Positions, Position0),
    !,
    Position = Position0.
argument_position(brace_term_position(_, _, Position), 1, Position) :- !.
argument_position(list_position(From, To, [First|Rest], Tail), Index, Position) :-
    !,
    (   Index =:= 1
    ->  Position = First
    ;   Rest == [],
        Tail \== none
    ->  Position = Tail
    ;   Position = list_position(From, To, Rest, Tail)
    ).
argument_position(Position, _, Start-End) :-
    span(Position, Start, End).

%!  name_position(+Position, -NamePosition) is det.
%
%   Where the name of a term is.

name_position(parentheses_term_position(_, _, Inner), Position) :-
    !,
    name_position(Inner, Position).
name_position(term_position(_, _, Start, End, _), Start-End) :- !.
name_position(Position, Start-End) :-
    span(Position, Start, End).

%!  element_position(+Position, +Index, -ElementPosition) is det.
%
%   Where the element of a list with that Index, from 1, is.

element_position(Position, Index, Found) :-
    (   Position = list_position(_, _, Elements, _),
        nth1(Index, Elements, Element)
    ->  Found = Element
    ;   span(Position, Start, End),
        Found = Start-End
    ).

%!  fault_at(+Position, +Format, +Args, -Fault) is det.
%
%   Fault is fault(Start, End, Format, Args).

fault_at(Position, Format, Args, fault(Start, End, Format, Args)) :-
    span(Position, Start, End).
