// Stands in for std_srvs in tests.
#ifndef STD_SRVS__SRV__SET_BOOL_HPP_
#define STD_SRVS__SRV__SET_BOOL_HPP_

#include <string>

#include "stand_in_text.hpp"

namespace std_srvs::srv
{

struct SetBool
{
  struct Request
  {
    bool data = false;
    void read_from(std::istream & in) {stand_in::read(in, data);}
  };
  struct Response
  {
    bool success = false;
    std::string message;
    void write_to(std::ostream & out) const
    {
      stand_in::write(out, success);
      stand_in::write(out, message);
    }
  };
};

}  // namespace std_srvs::srv

#endif  // STD_SRVS__SRV__SET_BOOL_HPP_
