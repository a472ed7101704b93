:- module(facetlog_variables, [ among/2           % +Variables, +Variable
                              ]).

/** <module> Variables as values
*/

%!  among(+Variables, +Variable) is semidet.
%
%   Variable itself is one of Variables.

among([Other|Others], Variable) :-
    ( Other == Variable -> true ; among(Others, Variable) ).
